(** * General linear methods and their order

    The definitions come first: they are what has to be read to know what is proved. They speak of
    [numbers], which are the elements of any field of characteristic zero when a theorem is stated,
    and [num] when it is checked. *)
From Coq Require Import List Arith Lia Bool QArith Field.
From Glmref Require Import Trees Field.
Import ListNotations.
Set Implicit Arguments.
Local Open Scope nat_scope.

Section Vectors.
Variable R : numbers.

Definition vec := list R.
Definition mat := list vec.

Fixpoint zip (f : R -> R -> R) (x y : vec) : vec := match x, y with
  | a :: x', b :: y' => f a b :: zip f x' y' | _, _ => [] end.
Definition vadd := zip (add R).
Definition vmul := zip (mul R).
Definition scale (a : R) : vec -> vec := map (mul R a).
Definition sum : vec -> R := fold_right (add R) (rat R 0).
Definition dot (x y : vec) : R := sum (vmul x y).
Definition mv (M : mat) (x : vec) : vec := map (fun row => dot row x) M.
Definition ones n : vec := repeat (rat R 1) n.

Definition rect m n (M : mat) : bool :=
  (length M =? m) && forallb (fun row => length row =? n) M.

(** Y = h A f(Y) + U y, y+ = h B f(Y) + V y, with [slopes] evaluations of f. *)
Record glm := { A : mat; U : mat; B : mat; V : mat; slopes : nat }.
End Vectors.

Section Order.
Variables (P : palette) (R : numbers).
Local Notation tree := (tree P).

(** One method for the vertices of each colour. *)
Variable M : P -> glm R.

(** Shapes fit: the stages that the method of colour d makes are arguments of its parents. *)
Definition shaped : bool :=
  forallb (fun c => let m := M c in
    rect (length (A m)) (slopes m) (A m) && rect (length (A m)) (length (V m)) (U m) &&
    rect (length (V m)) (slopes m) (B m) && rect (length (V m)) (length (V m)) (V m) &&
    forallb (fun d => implb (edge P c d) (length (A (M d)) =? slopes m)) (colours P)) (colours P).

(** A starting method as a series: [u] at the empty tree, [eta] at the others. *)
Variables (u : P -> vec R) (eta : tree -> vec R).

(** Stage weights. At a tree [t1 .. tm] the slopes hf(Y) have the product of xi(t1) .. xi(tm),
    where xi = A slope + U eta is the series of the stages. *)
Fixpoint slope (t : tree) : vec R := match t with
  | leaf _ c => ones R (slopes (M c))
  | graft t s => vmul (slope t)
      (vadd (mv (A (M (root s))) (slope s)) (mv (U (M (root s))) (eta s))) end.

(** Sum over all ways to cut branches off t: what is kept, times 1/density of each removed tree. *)
Fixpoint prune (t : tree) (f : tree -> vec R) : vec R := match t with
  | leaf _ c => f (leaf _ c)
  | graft t s => prune t (fun kept =>
      vadd (scale (rat R (1 # density s)) (f kept)) (prune s (fun branch => f (graft kept branch))))
  end.

(** The exact flow for a step h, then the starting method. *)
Definition flow (t : tree) : vec R :=
  vadd (scale (rat R (1 # density t)) (u (root t))) (prune t eta).

(** A step after the start equals the start after the flow, on all trees up to order p. *)
Definition starting (p : nat) : Prop :=
  (forall c, length (u c) = length (V (M c)) /\ mv (V (M c)) (u c) = u c /\
             mv (U (M c)) (u c) = ones R (length (U (M c)))) /\
  (forall t, length (eta t) = length (V (M (root t)))) /\
  (forall t s, same t s -> eta t = eta s) /\
  (forall t, ok t = true -> size t <= p ->
     vadd (mv (B (M (root t))) (slope t)) (mv (V (M (root t))) (eta t)) = flow t).

(** The first value is the solution itself: no finishing method is needed. *)
Definition identity : Prop :=
  (forall c, hd (rat R 0) (u c) = rat R 1) /\ (forall t, hd (rat R 0) (eta t) = rat R 0).
End Order.
Arguments shaped {P R}. Arguments slope {P R}. Arguments prune {P R}. Arguments flow {P R}.
Arguments starting {P R}. Arguments identity {P R}.

(** Order p: some starting method exists. *)
Definition has_order (P : palette) R (M : P -> glm R) p : Prop :=
  shaped M = true /\ exists u eta, starting M u eta p.
Definition has_order_identity (P : palette) R (M : P -> glm R) p : Prop :=
  shaped M = true /\ exists u eta, starting M u eta p /\ identity u eta.

Arguments has_order {P R}. Arguments has_order_identity {P R}.

Lemma identity_order (P : palette) R (M : P -> glm R) p : has_order_identity M p -> has_order M p.
Proof. intros [S [u [eta [H _]]]]. split; [exact S | now exists u, eta]. Qed.

(** Runge-Kutta methods: b phi(t) = 1/density(t). *)
Fixpoint phi R (A : mat R) (t : tree rooted) : vec R := match t with
  | leaf _ _ => ones R (length A)
  | graft t s => vmul (phi A t) (mv A (phi A s)) end.
Definition rk_order R (A : mat R) (b : vec R) p : Prop :=
  rect (length b) (length b) A = true /\
  forall t : tree rooted, size t <= p -> dot b (phi A t) = rat R (1 # density t).

(** * Proofs from here on *)

Lemma prune_ext P R (t : tree P) : forall f g : tree P -> vec R,
  (forall k, f k = g k) -> prune t f = prune t g.
Proof.
  induction t as [c|t IHt s IHs]; simpl; intros f g H; auto.
  apply IHt. intro k. rewrite H. f_equal. apply IHs. auto.
Qed.

(** ** Numbers of the tower and their values: all definitions commute with [eval] *)

Section Hom.
Variables (K R : numbers) (h : K -> R).
Hypothesis h_rat : forall q, h (rat K q) = rat R q.
Hypothesis h_add : forall x y, h (add K x y) = add R (h x) (h y).
Hypothesis h_mul : forall x y, h (mul K x y) = mul R (h x) (h y).

Definition value_v : vec K -> vec R := map h.
Definition value_m : mat K -> mat R := map value_v.
Definition value (m : glm K) : glm R :=
  {| A := value_m (A m); U := value_m (U m); B := value_m (B m); V := value_m (V m);
     slopes := slopes m |}.

Lemma zip_hom f g x y : (forall a b, h (f a b) = g (h a) (h b)) ->
  value_v (zip f x y) = zip g (value_v x) (value_v y).
Proof.
  intro H. revert y; induction x as [|a x IH]; intros [|b y]; simpl; auto. now rewrite H, IH.
Qed.

Lemma vadd_hom x y : value_v (vadd x y) = vadd (value_v x) (value_v y).
Proof. now apply zip_hom. Qed.

Lemma vmul_hom x y : value_v (vmul x y) = vmul (value_v x) (value_v y).
Proof. now apply zip_hom. Qed.

Lemma scale_hom a x : value_v (scale a x) = scale (h a) (value_v x).
Proof. unfold value_v, scale. rewrite !map_map. apply map_ext. auto. Qed.

Lemma sum_hom x : h (sum x) = sum (value_v x).
Proof. induction x; simpl; auto. rewrite h_add. now f_equal. Qed.

Lemma dot_hom x y : h (dot x y) = dot (value_v x) (value_v y).
Proof. unfold dot. now rewrite sum_hom, vmul_hom. Qed.

Lemma mv_hom M x : value_v (mv M x) = mv (value_m M) (value_v x).
Proof. unfold mv, value_m, value_v. rewrite !map_map. apply map_ext. intro. apply dot_hom. Qed.

Lemma ones_hom n : value_v (ones K n) = ones R n.
Proof.
  unfold ones, value_v. induction n as [|n IH]; simpl; auto. now rewrite h_rat, IH.
Qed.

Lemma rect_hom m n M : rect m n (value_m M) = rect m n M.
Proof.
  unfold rect, value_m, value_v. rewrite map_length. f_equal.
  induction M as [|row M IH]; simpl; auto. now rewrite map_length, IH.
Qed.

Variable P : palette.
Variables (M : P -> glm K) (u : P -> vec K) (eta : tree P -> vec K).
Let M' c := value (M c).
Let u' c := value_v (u c).
Let eta' t := value_v (eta t).

Lemma value_length N : length (value_m N) = length N.
Proof. apply map_length. Qed.

Lemma forallb_same X (f g : X -> bool) l : (forall x, f x = g x) -> forallb f l = forallb g l.
Proof. intro H. induction l; simpl; auto. now rewrite H, IHl. Qed.

Lemma shaped_hom : shaped M' = shaped M.
Proof.
  unfold shaped. apply forallb_same. intro c. unfold M', value. cbn [A U B V slopes].
  rewrite !rect_hom, !value_length. f_equal. apply forallb_same. intro d.
  now rewrite value_length.
Qed.

Lemma slope_hom (t : tree P) : value_v (slope M eta t) = slope M' eta' t.
Proof.
  induction t as [c|t IHt s IHs]; simpl; [apply ones_hom|].
  now rewrite vmul_hom, vadd_hom, !mv_hom, IHt, IHs.
Qed.

Lemma prune_hom (t : tree P) : forall f, value_v (prune t f) = prune t (fun k => value_v (f k)).
Proof.
  induction t as [c|t IHt s IHs]; simpl; intro f; auto.
  rewrite IHt. apply prune_ext. intro k. now rewrite vadd_hom, scale_hom, h_rat, IHs.
Qed.

Lemma flow_hom (t : tree P) : value_v (flow u eta t) = flow u' eta' t.
Proof. unfold flow. now rewrite vadd_hom, scale_hom, h_rat, prune_hom. Qed.
End Hom.

(** ** The order of the branches does not matter: it is enough to look at one tree of each class *)

Section Same.
Variables (F : field) (P : palette).
Add Field F_field : (laws F).
Local Notation R := (of_field F).
Local Notation tree := (tree P).

Lemma zip_comm (f : R -> R -> R) : (forall a b, f a b = f b a) ->
  forall x y, zip f x y = zip f y x.
Proof. intros C x. induction x as [|a x IH]; intros [|b y]; simpl; auto. now rewrite C, IH. Qed.

Lemma zip_assoc (f : R -> R -> R) : (forall a b c, f a (f b c) = f (f a b) c) ->
  forall x y z, zip f x (zip f y z) = zip f (zip f x y) z.
Proof.
  intros C x. induction x as [|a x IH]; intros [|b y] [|c z]; simpl; auto. now rewrite C, IH.
Qed.

Lemma vadd_comm (x y : vec R) : vadd x y = vadd y x.
Proof. apply zip_comm. intros. simpl. ring. Qed.

Lemma vadd_assoc (x y z : vec R) : vadd x (vadd y z) = vadd (vadd x y) z.
Proof. apply zip_assoc. intros. simpl. ring. Qed.

Lemma vmul_swap (x y z : vec R) : vmul (vmul x y) z = vmul (vmul x z) y.
Proof.
  unfold vmul. rewrite <- !zip_assoc by (intros; simpl; ring). f_equal.
  apply zip_comm. intros. simpl. ring.
Qed.

Lemma vadd_shuffle (a b c d : vec R) : vadd (vadd a b) (vadd c d) = vadd (vadd a c) (vadd b d).
Proof. now rewrite !vadd_assoc, <- (vadd_assoc a b c), (vadd_comm b c), vadd_assoc. Qed.

Lemma scale_vadd a (x y : vec R) : scale a (vadd x y) = vadd (scale a x) (scale a y).
Proof.
  revert y; induction x as [|b x IH]; intros [|c y]; simpl; auto. unfold vadd, scale in *. simpl.
  rewrite IH. f_equal. ring.
Qed.

Lemma scale_swap a b (x : vec R) : scale a (scale b x) = scale b (scale a x).
Proof. unfold scale. rewrite !map_map. apply map_ext. intro. simpl. ring. Qed.

(** Pruning is linear, so two prunings may change places. *)
Lemma prune_add t : forall f g : tree -> vec R,
  prune t (fun k => vadd (f k) (g k)) = vadd (prune t f) (prune t g).
Proof.
  induction t as [c|t IHt s IHs]; simpl; intros f g; auto.
  rewrite <- IHt. apply prune_ext. intro k. rewrite IHs, scale_vadd. apply vadd_shuffle.
Qed.

Lemma prune_scale a t : forall f : tree -> vec R,
  prune t (fun k => scale a (f k)) = scale a (prune t f).
Proof.
  induction t as [c|t IHt s IHs]; simpl; intro f; auto.
  rewrite <- IHt. apply prune_ext. intro k. now rewrite IHs, scale_vadd, scale_swap.
Qed.

Lemma prune_swap a b : forall f : tree -> tree -> vec R,
  prune a (fun x => prune b (f x)) = prune b (fun y => prune a (fun x => f x y)).
Proof.
  induction a as [c|a IHa s IHs]; simpl; intro f; auto.
  rewrite <- IHa. apply prune_ext. intro k. now rewrite IHs, prune_add, prune_scale.
Qed.

Definition respects (f : tree -> vec R) := forall t s, same t s -> f t = f s.

Lemma same_prune t s : same t s -> forall f, respects f -> prune t f = prune s f.
Proof.
  induction 1 as [| | |t t' s s' Ht IHt Hs IHs|t a b]; intros f Rf; auto.
  - now symmetry; apply IHsame.
  - rewrite IHsame1, IHsame2 by assumption. reflexivity.
  - simpl. rewrite (same_density Hs). rewrite IHt.
    + apply prune_ext. intro k. f_equal. apply IHs. intros x y E. apply Rf, same_graft; auto.
      apply same_refl.
    + intros x y E. rewrite (Rf _ _ E). f_equal. apply prune_ext. intro k.
      apply Rf, same_graft; auto. apply same_refl.
  - simpl. apply prune_ext. intro k.
    rewrite !scale_vadd, !prune_add, !prune_scale, (scale_swap (rat R (1 # density a))).
    rewrite <- !vadd_assoc. f_equal. rewrite (prune_swap a b).
    rewrite !vadd_assoc. f_equal; [apply vadd_comm|].
    apply prune_ext. intro x. apply prune_ext. intro y. apply Rf, same_swap.
Qed.

Variables (M : P -> glm R) (u : P -> vec R) (eta : tree -> vec R).
Hypothesis eta_respects : respects eta.

Lemma same_slope : respects (slope M eta).
Proof.
  intros t s. induction 1 as [| | |t t' s s' Ht IHt Hs IHs|t a b]; simpl; try congruence.
  - now rewrite IHt, IHs, (same_root Hs), (eta_respects Hs).
  - apply vmul_swap.
Qed.

Lemma same_flow : respects (flow u eta).
Proof.
  intros t s H. unfold flow. now rewrite (same_density H), (same_root H), (same_prune H).
Qed.
End Same.

(** ** The checks *)

Section Check.
Variable P : palette.
Variable T : tower.
Local Notation K := (in_tower T).
Local Notation tree := (tree P).
Variable M : P -> glm K.
Variables (u : P -> vec K) (witness : list (tree * vec K)).   (* trees left out have eta = 0 *)

Definition sorted_witness := map (fun e => (canon (fst e), snd e)) witness.
Definition series (t : tree) : vec K :=
  match find (fun e => eqb (fst e) (canon t)) sorted_witness with
  | Some e => snd e
  | None => repeat zero (length (V (M (root t)))) end.

Fixpoint veq (x y : list num) : bool := match x, y with
  | [], [] => true
  | a :: x', b :: y' => equal a b && veq x' y'
  | _, _ => false end.

Definition slopes_of : list tree -> list (tree * vec K) :=
  table (fun c => ones K (slopes (M c)))
    (fun s x y => vmul x (vadd (mv (A (M (root s))) y) (mv (U (M (root s))) (series s)))).

Definition identity_holds (e : tree * vec K) : bool :=
  let t := fst e in
  veq (vadd (mv (B (M (root t))) (snd e)) (mv (V (M (root t))) (series t))) (flow u series t).

Definition check (p : nat) : bool :=
  shaped M
  && forallb (fun c => (length (u c) =? length (V (M c))) && veq (mv (V (M c)) (u c)) (u c)
                       && veq (mv (U (M c)) (u c)) (ones K (length (U (M c))))) (colours P)
  && forallb (fun e => length (snd e) =? length (V (M (root (fst e))))) sorted_witness
  && forallb identity_holds (slopes_of (trees P p)).

Definition check_identity : bool :=
  forallb (fun c => equal (hd zero (u c)) (Rat 1)) (colours P)
  && forallb (fun e => is_zero (hd zero (snd e))) sorted_witness.

Variables (F : field) (roots : list F).
Hypothesis roots_ok : roots_of F T roots.
Local Notation ev := (eval F roots).
Local Notation vv := (@value_v K (of_field F) ev).

Lemma ev_rat q : ev (rat K q) = rat (of_field F) q.
Proof. reflexivity. Qed.
Lemma ev_add x y : ev (add K x y) = add (of_field F) (ev x) (ev y).
Proof. apply nadd_eval. Qed.
Lemma ev_mul x y : ev (mul K x y) = mul (of_field F) (ev x) (ev y).
Proof. now apply nmul_eval. Qed.

Lemma veq_value x y : veq x y = true -> vv x = vv y.
Proof.
  revert y; induction x as [|a x IH]; intros [|b y] H; try discriminate; auto.
  simpl in *. apply andb_true_iff in H. f_equal; [apply equal_eval | apply IH]; tauto.
Qed.

Lemma slope_fold t : slope M series t = fold (fun c => ones K (slopes (M c)))
  (fun s x y => vmul x (vadd (mv (A (M (root s))) y) (mv (U (M (root s))) (series s)))) t.
Proof. induction t; simpl; congruence. Qed.

Lemma series_same t s : same t s -> series t = series s.
Proof. intro H. unfold series. now rewrite (same_canon_eq H), (same_root H). Qed.

Lemma series_length : forallb (fun e => length (snd e) =? length (V (M (root (fst e)))))
  sorted_witness = true -> forall t, length (series t) = length (V (M (root t))).
Proof.
  intros L t. unfold series. destruct (find _ _) as [e|] eqn:H; [|apply repeat_length].
  apply find_some in H. destruct H as [I E]. apply eqb_eq in E.
  rewrite forallb_forall in L. specialize (L _ I). apply Nat.eqb_eq in L.
  etransitivity; [exact L|]. rewrite <- (same_root (canon_same t)).
  exact (f_equal (fun x => length (V (M (root x)))) E).
Qed.

Definition value_of : P -> glm (of_field F) := fun c => @value K (of_field F) ev (M c).

Lemma check_starting p : check p = true ->
  starting value_of (fun c => vv (u c)) (fun t => vv (series t)) p.
Proof.
  unfold check. rewrite !andb_true_iff, !forallb_forall. intros [[[_ S] L] C].
  rewrite <- forallb_forall in L.
  split; [|split; [|split]].
  - intro c. specialize (S c (colours_all P c)). rewrite !andb_true_iff in S.
    destruct S as [[S1 S2] S3]. apply Nat.eqb_eq in S1.
    unfold value_of, value, value_v, value_m. simpl. rewrite !map_length. split; [exact S1|].
    apply veq_value in S2, S3. split.
    + rewrite <- S2 at 2. symmetry. apply mv_hom; [apply ev_rat | apply ev_add | apply ev_mul].
    + etransitivity; [symmetry; apply mv_hom; auto using ev_rat, ev_add, ev_mul|].
      rewrite S3. now apply ones_hom.
  - intro t. unfold value_of, value, value_v, value_m. simpl. rewrite !map_length.
    now apply series_length.
  - intros t s H. now rewrite (series_same H).
  - intros t O N.
    assert (G : respects (fun t : tree => vv (series t))).
    { intros a b H. now rewrite (series_same H). }
    rewrite <- (same_slope value_of G (canon_same t)).
    rewrite <- (same_flow (fun c => vv (u c)) G (canon_same t)).
    rewrite <- (G _ _ (canon_same t)). rewrite <- (same_root (canon_same t)).
    specialize (C _ (table_in _ _ _ _ (trees_complete t O N))).
    unfold identity_holds in C. cbn [fst snd] in C. rewrite <- slope_fold in C.
    apply veq_value in C.
    rewrite flow_hom, vadd_hom, !mv_hom, slope_hom in C by auto using ev_rat, ev_add, ev_mul.
    exact C.
Qed.

Theorem check_order p : check p = true -> has_order value_of p.
Proof.
  intro C. split.
  - unfold value_of. rewrite shaped_hom. unfold check in C. rewrite !andb_true_iff in C. tauto.
  - eexists _, _. exact (check_starting _ C).
Qed.

Lemma check_identity_value : check_identity = true ->
  identity (fun c => vv (u c)) (fun t => vv (series t)).
Proof.
  unfold check_identity. rewrite andb_true_iff, !forallb_forall. intros [I J].
  split.
  - intro c. specialize (I c (colours_all P c)). apply (equal_eval F roots) in I.
    destruct (u c); simpl in *; exact I.
  - intro t. unfold series. destruct (find _ _) as [e|] eqn:H.
    + apply find_some in H. destruct H as [H _]. specialize (J _ H).
      apply (is_zero_eval F roots) in J. rewrite <- of_Q_0 in J.
      destruct e as [k [|x l]]; [reflexivity | exact J].
    + destruct (length (V (M (root t)))); reflexivity.
Qed.

Theorem check_order_identity p : check p && check_identity = true ->
  has_order_identity value_of p.
Proof.
  rewrite andb_true_iff. intros [C I]. split; [exact (proj1 (check_order _ C))|].
  eexists _, _. split; [exact (check_starting _ C) | exact (check_identity_value I)].
Qed.
End Check.

(** ** Runge-Kutta methods *)

Ltac homs := intros; first [reflexivity | apply ev_rat | apply ev_add | now apply ev_mul].


Section RungeKutta.
Variable T : tower.
Local Notation K := (in_tower T).
Variables (A : mat K) (b : vec K).

Definition phis : list (tree rooted) -> list (tree rooted * vec K) :=
  table (fun _ => ones K (length A)) (fun _ x y => vmul x (mv A y)).

Definition check_rk p : bool :=
  rect (length b) (length b) A
  && forallb (fun e => equal (dot b (snd e)) (Rat (1 # density (fst e)))) (phis (trees rooted p)).

Variables (F : field) (roots : list F).
Hypothesis roots_ok : roots_of F T roots.
Local Notation R := (of_field F).
Local Notation ev := (eval F roots).
Local Notation vm := (@value_m K R ev).
Local Notation vv := (@value_v K R ev).

Lemma phi_fold t :
  phi A t = fold (P := rooted) (fun _ => ones K (length A)) (fun _ x y => vmul x (mv A y)) t.
Proof. induction t as [c|t IHt s IHs]; auto. cbn [phi fold]. now rewrite <- IHt, <- IHs. Qed.

Lemma phi_hom t : vv (phi A t) = phi (vm A) t.
Proof.
  induction t as [c|t IHt s IHs]; simpl.
  - rewrite value_length. now apply ones_hom.
  - rewrite vmul_hom, mv_hom by homs. now rewrite IHt, IHs.
Qed.

Lemma phi_same (N : mat R) t s : same t s -> phi N t = phi N s.
Proof. induction 1; simpl; try congruence. apply vmul_swap. Qed.

Theorem check_rk_order p : check_rk p = true -> rk_order (vm A) (vv b) p.
Proof.
  unfold check_rk. rewrite andb_true_iff, forallb_forall. intros [S C]. split.
  - rewrite rect_hom. unfold value_v. now rewrite map_length.
  - intros t N. assert (O : ok t = true).
    { clear. induction t; simpl; auto. now rewrite IHt1, IHt2. }
    rewrite <- (phi_same _ (canon_same t)), <- (same_density (canon_same t)).
    specialize (C _ (table_in _ _ _ _ (trees_complete t O N))). cbn [fst snd] in C.
    rewrite <- phi_fold in C. apply (equal_eval F roots) in C.
    rewrite (@dot_hom K R ev) in C by homs. rewrite phi_hom in C. exact C.
Qed.

(** One tree whose identity fails: the difference has an inverse in the tower. *)
Definition check_not_rk p t inverse : bool :=
  (size t <=? p)
  && equal (nmul T (nadd (dot b (phi A t)) (Rat (-1 # density t))) inverse) (Rat 1).

Theorem check_rk_not_order p t inverse : check_not_rk p t inverse = true ->
  ~ rk_order (vm A) (vv b) p.
Proof.
  Add Field F_field'' : (laws F).
  unfold check_not_rk. rewrite andb_true_iff. intros [N C] [_ H]. apply Nat.leb_le in N.
  specialize (H t N). rewrite <- phi_hom, <- (@dot_hom K R ev) in H by homs.
  apply (equal_eval F roots) in C. rewrite nmul_eval, nadd_eval in C by assumption.
  simpl in H. rewrite H in C. simpl in C. rewrite of_Q_1 in C.
  rewrite <- of_Q_add, (@of_Q_eq F _ 0%Q), of_Q_0 in C.
  - apply (F_1_neq_0 (laws F)). rewrite <- C. ring.
  - unfold Qeq, Qplus. cbn [Qnum Qden]. ring.
Qed.
End RungeKutta.

(** ** The numbers of a tower in a field, for the statements of theorems *)

Section Statements.
Variables (F : field) (x : list F).
Definition vector (a : list num) : vec (of_field F) := map (eval F x) a.
Definition matrix (a : list (list num)) : mat (of_field F) := map vector a.
Definition method (T : tower) (m : glm (in_tower T)) : glm (of_field F) :=
  @value (in_tower T) (of_field F) (eval F x) m.
End Statements.
Arguments method F x T m : clear implicits.
