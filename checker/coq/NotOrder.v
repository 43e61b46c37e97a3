(** * The order is not higher: one tree fails

    Where the first value is the solution itself, and 1 is a simple eigenvalue of V, there is one
    starting series only. So a tree whose condition fails for it fails for all. *)
From Coq Require Import List Arith Lia Bool QArith Field.
From Glmref Require Import Trees Field GLM Symplectic.
Import ListNotations.
Set Implicit Arguments.
Local Open Scope nat_scope.

(** x = Z (I - V) x + x_1 a for all x: Z is shown by its rows, [left] is a row with w V = w. *)
Definition resolves (R : numbers) (V Z : mat R) (a : vec R) : Prop :=
  0 < length V /\ rect (length V) (length V) V = true /\ forall i, i < length V ->
  length (nth i Z []) = length V /\
  vadd (mv (tr V) (nth i Z [])) (unit_row R (length V) i)
  = vadd (nth i Z []) (scale (nth i a (rat R 0)) (unit_row R (length V) 0)).

Section Unique.
Variables (P : palette) (F : field).
Add Field F_field : (laws F).
Local Notation R := (of_field F).
Local Notation tree := (tree P).
Local Infix "+" := (fadd F).
Local Infix "-" := (fsub F).
Local Infix "*" := (fmul F).

Ltac fring := simpl; match goal with |- ?a = ?b => refine (_ : @eq (element F) a b) end; ring.

Lemma prune_ext_in (t : tree) : ok t = true -> forall f g : tree -> vec R,
  (forall k, ok k = true -> root k = root t -> size k <= size t -> f k = g k) ->
  prune t f = prune t g.
Proof.
  induction t as [c|t IHt s IHs]; simpl; intros O f g H; [now apply H|].
  rewrite !andb_true_iff in O. destruct O as [[Ot Os] E]. apply IHt; auto. intros k Ok Rk Sk.
  rewrite (H k) by (auto; lia). f_equal. apply IHs; auto. intros b Ob Rb Sb.
  apply H; simpl; [now rewrite Ok, Ob, Rk, Rb | auto | lia].
Qed.

Lemma prune_length n (t : tree) : forall f : tree -> vec R,
  (forall k, root k = root t -> length (f k) = n) -> length (prune t f) = n.
Proof.
  induction t as [c|t IHt s IHs]; simpl; intros f H; [now apply H|].
  apply IHt. intros k Rk. apply vadd_length.
  - unfold scale. rewrite map_length. now apply H.
  - apply IHs. intros b _. now apply H.
Qed.

(** Two series that agree on all smaller trees: pruning differs by their difference at the tree. *)
Lemma prune_diff n (z : vec R) (t : tree) : ok t = true -> forall f g : tree -> vec R,
  (forall k, root k = root t -> length (f k) = n) ->
  (forall k, root k = root t -> length (g k) = n) ->
  (forall k, ok k = true -> root k = root t -> size k < size t -> f k = g k) ->
  dot z (prune t f) + dot z (g t) = dot z (prune t g) + dot z (f t).
Proof.
  induction t as [c|t IHt s IHs]; simpl; intros O f g Lf Lg H; [fring|].
  rewrite !andb_true_iff in O. destruct O as [[Ot Os] E].
  pose proof (size_pos t) as Pt. pose proof (size_pos s) as Ps.
  set (f1 := fun k => vadd (scale _ (f k)) _). set (g1 := fun k => vadd (scale _ (g k)) _).
  assert (A : dot z (prune t f1) + dot z (g1 t) = dot z (prune t g1) + dot z (f1 t)).
  { apply IHt; auto.
    - intros k Rk. apply vadd_length; [unfold scale; rewrite map_length; now apply Lf|].
      apply prune_length. intros b _. now apply Lf.
    - intros k Rk. apply vadd_length; [unfold scale; rewrite map_length; now apply Lg|].
      apply prune_length. intros b _. now apply Lg.
    - intros k Ok Rk Sk. unfold f1, g1. rewrite (H k) by (auto; lia). f_equal.
      apply prune_ext_in; auto. intros b Ob Rb Sb.
      apply H; simpl; [now rewrite Ok, Ob, Rk, Rb | auto | lia]. }
  assert (B : dot z (prune s (fun b => f (graft t b))) + dot z (g (graft t s))
            = dot z (prune s (fun b => g (graft t b))) + dot z (f (graft t s))).
  { apply (IHs Os (fun b => f (graft t b)) (fun b => g (graft t b))).
    - intros b _. now apply Lf.
    - intros b _. now apply Lg.
    - intros b Ob Rb Sb. apply H; simpl; [now rewrite Ot, Ob, Rb | auto | lia]. }
  unfold f1 at 2, g1 at 1 in A. rewrite (H t) in A by (auto; lia).
  assert (L : forall h : tree -> vec R, (forall k, root k = root t -> length (h k) = n) ->
    length (scale (rat R (1 # density s)) (g t)) = length (prune s (fun b => h (graft t b)))).
  { intros h Lh. unfold scale. rewrite map_length. transitivity n; [now apply Lg|].
    symmetry. apply prune_length. intros b _. now apply Lh. }
  rewrite !dot_vadd in A by (apply L; auto).
  set (a := dot z (prune s (fun b => f (graft t b)))) in *.
  set (b := dot z (prune s (fun b => g (graft t b)))) in *.
  set (c := dot z (scale _ (g t))) in *. change (add R) with (fadd F) in A.
  transitivity (dot z (prune t f1) + (c + b) + (a + dot z (g (graft t s))) - (c + b + a)); [fring|].
  rewrite A, B. fring.
Qed.

Lemma slope_ext (M : P -> glm R) (t : tree) : ok t = true -> forall e g : tree -> vec R,
  (forall s, ok s = true -> size s < size t -> e s = g s) -> slope M e t = slope M g t.
Proof.
  induction t as [c|t IHt s IHs]; simpl; intros O e g H; auto.
  rewrite !andb_true_iff in O. destruct O as [[Ot Os] E].
  pose proof (size_pos t). rewrite (H s) by (auto; lia).
  rewrite (IHt Ot e g), (IHs Os e g); auto; intros; apply H; auto; lia.
Qed.

Lemma dot_unit_low (x : vec R) : forall i k, i < k ->
  dot (map (fun j => rat R (if i =? j then 1 else 0)) (seq k (length x))) x = rat R 0.
Proof.
  induction x as [|b x IH]; intros i k H; [reflexivity|]. unfold dot, vmul in *. simpl.
  specialize (IH i (S k)). simpl in IH. rewrite IH by lia.
  replace (i =? k) with false by (symmetry; apply Nat.eqb_neq; lia). simpl. rewrite of_Q_0. fring.
Qed.

Lemma dot_unit (x : vec R) : forall i k, k <= i < k + length x ->
  dot (map (fun j => rat R (if i =? j then 1 else 0)) (seq k (length x))) x
  = nth (i - k) x (rat R 0).
Proof.
  induction x as [|b x IH]; intros i k H; [simpl in H; lia|].
  destruct (Nat.eq_dec i k) as [<-|N].
  - pose proof (@dot_unit_low x i (S i)) as Z. unfold dot, vmul in *. simpl in *.
    rewrite Z, Nat.eqb_refl, Nat.sub_diag by lia. simpl. rewrite of_Q_0, of_Q_1. fring.
  - specialize (IH i (S k)). unfold dot, vmul in *. simpl in *. rewrite IH by lia.
    replace (i =? k) with false by (symmetry; apply Nat.eqb_neq; lia).
    replace (i - k)%nat with (S (i - S k))%nat by lia. simpl. rewrite of_Q_0. fring.
Qed.

Lemma dot_unit_row n i (x : vec R) : length x = n -> i < n ->
  dot (unit_row R n i) x = nth i x (rat R 0).
Proof. intros <- H. unfold unit_row. rewrite dot_unit by lia. now rewrite Nat.sub_0_r. Qed.

Lemma unit_row_length n i : length (unit_row R n i) = n.
Proof. unfold unit_row. now rewrite map_length, seq_length. Qed.

(** (I - V) (x - y) = 0 and x_1 = y_1: then x = y. *)
Lemma unique (V Z : mat R) (a x y : vec R) : resolves V Z a ->
  length x = length V -> length y = length V -> hd (rat R 0) x = hd (rat R 0) y ->
  (forall z : vec R, length z = length V ->
     dot z (mv V x) + dot z y = dot z (mv V y) + dot z x) -> x = y.
Proof.
  intros [N [S H]] Lx Ly Hd E. apply nth_ext with (d := rat R 0) (d' := rat R 0); [congruence|].
  intros i I. rewrite Lx in I. destruct (H i I) as [Lz Q]. specialize (E _ Lz).
  set (z := nth i Z []) in *. set (b := nth i a (rat R 0)) in *.
  assert (D : forall v : vec R, length v = length V ->
    dot z (mv V v) + nth i v (rat R 0) = dot z v + b * hd (rat R 0) v).
  { intros v Lv. assert (T : length (mv (tr V) z) = length V).
    { rewrite (tr_columns _ _ _ _ S N). unfold mv, columns. now rewrite !map_length, seq_length. }
    apply (f_equal (fun q => dot v q)) in Q.
    rewrite !dot_vadd in Q by (unfold scale; rewrite ?map_length, ?unit_row_length; congruence).
    rewrite dot_scale, !(dot_comm _ v), !dot_unit_row in Q by auto.
    rewrite (tr_columns _ _ _ _ S N) in Q. apply rect_rows in S. destruct S as [_ S].
    rewrite adjoint in Q by auto. destruct v; exact Q. }
  pose proof (D x Lx) as Dx. pose proof (D y Ly) as Dy. rewrite Hd in Dx.
  transitivity (dot z (mv V x) + nth i x (rat R 0) + (dot z y - (dot z (mv V x) + dot z y)));
    [fring|]. rewrite Dx, E.
  transitivity (dot z (mv V y) + nth i y (rat R 0) - dot z (mv V y)); [rewrite Dy; fring | fring].
Qed.

Variables (M : P -> glm R) (Z : P -> mat R) (a : P -> vec R).
Hypothesis M_shaped : shaped M = true.
Hypothesis Z_resolves : forall c, resolves (V (M c)) (Z c) (a c).

Lemma B_length c (x : vec R) : length (mv (B (M c)) x) = length (V (M c)).
Proof.
  unfold shaped in M_shaped. rewrite forallb_forall in M_shaped.
  specialize (M_shaped c (colours_all P c)). rewrite !andb_true_iff in M_shaped.
  destruct M_shaped as [[[_ H] _] _]. apply rect_rows in H. unfold mv. now rewrite map_length.
Qed.

Lemma u_unique (u v : P -> vec R) (e g : tree -> vec R) p q : starting M u e p ->
  starting M v g q -> identity u e -> identity v g -> forall c, u c = v c.
Proof.
  intros [U _] [W _] [I _] [J _] c. destruct (U c) as [Lu [Fu _]], (W c) as [Lv [Fv _]].
  apply unique with (1 := Z_resolves c); auto; [now rewrite I, J|].
  intros z _. rewrite Fu, Fv. fring.
Qed.

(** What the conditions of two starting series say of their difference. *)
Lemma conditions (u : P -> vec R) (e g : tree -> vec R) (t : tree) (z : vec R) p q :
  starting M u e p -> starting M u g q -> ok t = true -> size t <= q ->
  (forall s, ok s = true -> size s < size t -> e s = g s) ->
  dot z (mv (B (M (root t))) (slope M e t)) + dot z (mv (V (M (root t))) (g t)) + dot z (e t)
  = dot z (flow u e t) + dot z (g t).
Proof.
  intros [U [Le [_ _]]] [_ [Lg [_ Cg]]] O N A. specialize (Cg t O N).
  rewrite (@slope_ext M t O e g A).
  apply (f_equal (fun x => dot z x)) in Cg. rewrite dot_vadd in Cg.
  2:{ rewrite B_length. unfold mv. now rewrite map_length. }
  change (add R) with (fadd F) in Cg. rewrite Cg.
  destruct (U (root t)) as [Lu _].
  assert (D : forall h : tree -> vec R, (forall t, length (h t) = length (V (M (root t)))) ->
    dot z (flow u h t) = dot z (scale (rat R (1 # density t)) (u (root t))) + dot z (prune t h)).
  { intros h Lh. unfold flow. rewrite dot_vadd; [reflexivity|]. unfold scale. rewrite map_length, Lu.
    symmetry. apply prune_length. intros k Rk. now rewrite Lh, Rk. }
  rewrite !D by assumption.
  assert (E : dot z (prune t e) + dot z (g t) = dot z (prune t g) + dot z (e t)).
  { apply prune_diff with (n := length (V (M (root t)))); auto.
    - intros k Rk. now rewrite Le, Rk.
    - intros k Rk. now rewrite Lg, Rk. }
  set (c := dot z (scale _ _)) in *.
  transitivity (c + (dot z (prune t g) + dot z (e t))); [fring|]. rewrite <- E. fring.
Qed.

Lemma eta_unique (u : P -> vec R) (e g : tree -> vec R) p q : starting M u e p ->
  starting M u g q -> identity u e -> identity u g ->
  forall n t, ok t = true -> size t <= n -> n <= p -> n <= q -> e t = g t.
Proof.
  intros C D I J. induction n as [|n IH]; intros t O N Np Nq; [pose proof (size_pos t); lia|].
  assert (A : forall s, ok s = true -> size s < size t -> e s = g s) by (intros; apply IH; auto; lia).
  assert (A' : forall s, ok s = true -> size s < size t -> g s = e s) by (intros; symmetry; auto).
  pose proof C as [_ [Le _]]. pose proof D as [_ [Lg _]].
  apply unique with (1 := Z_resolves (root t)); auto.
  - destruct I as [_ I], J as [_ J]. now rewrite I, J.
  - intros z _.
    pose proof (@conditions u e e t z p p C C O (Nat.le_trans _ _ _ N Np) (fun s _ _ => eq_refl)) as E1.
    pose proof (@conditions u e g t z p q C D O (Nat.le_trans _ _ _ N Nq) A) as E2.
    set (b := dot z (mv (B _) _)) in *. set (k := dot z (flow u e t)) in *.
    transitivity (b + dot z (mv (V (M (root t))) (e t)) + dot z (e t)
                  + dot z (g t) - (b + dot z (e t))); [fring|].
    rewrite E1. transitivity (k + dot z (g t) - b); [fring|]. rewrite <- E2. fring.
Qed.

(** The condition of one tree more, seen by a row w with w V = w. *)
Lemma next_condition (u v : P -> vec R) (e g : tree -> vec R) p (t : tree) (w : vec R) :
  starting M u e p -> identity u e -> starting M v g (S p) -> identity v g ->
  ok t = true -> size t <= S p -> length w = length (V (M (root t))) ->
  mv (tr (V (M (root t)))) w = w ->
  dot w (mv (B (M (root t))) (slope M e t)) + dot w (e t) = dot w (flow u e t).
Proof.
  intros C I D J O N Lw W.
  assert (U : starting M u g (S p)).
  { pose proof (u_unique C D I J) as E. destruct D as [D1 [D2 [D3 D4]]], C as [C1 _].
    split; [exact C1 | split; [exact D2 | split; [exact D3|]]]. intros s Os Ns.
    unfold flow. rewrite E. now apply D4. }
  assert (Ju : identity u g) by (split; [apply I | apply J]).
  assert (A : forall s, ok s = true -> size s < size t -> e s = g s).
  { intros s Os Ss. apply (@eta_unique u e g p (S p) C U I Ju (size s)); auto; lia. }
  pose proof (@conditions u e g t w p (S p) C U O N A) as E. pose proof U as [_ [Lg _]].
  destruct (Z_resolves (root t)) as [Pos [S _]]. rewrite (tr_columns _ _ _ _ S Pos) in W.
  apply rect_rows in S. destruct S as [_ S].
  rewrite <- (adjoint _ _ _ S), W in E by auto.
  set (b := dot w (mv (B _) _)) in *.
  transitivity (b + dot w (g t) + dot w (e t) - dot w (g t)); [fring|]. rewrite E. fring.
Qed.
End Unique.
Arguments next_condition {P F M Z a}.

(** ** The check *)

Section Check.
Variables (P : palette) (T : tower).
Local Notation K := (in_tower T).
Local Notation tree := (tree P).
Variables (M : P -> glm K) (u : P -> vec K) (witness : list (tree * vec K)).
Variables (Z : P -> mat K) (a : P -> vec K).
Let eta := series M witness.

Definition check_resolves (V Z : mat K) (a : vec K) : bool :=
  (0 <? length V) && rect (length V) (length V) V &&
  forallb (fun i => (length (nth i Z []) =? length V) &&
    veq (vadd (mv (tr V) (nth i Z [])) (unit_row K (length V) i))
        (vadd (nth i Z []) (scale (nth i a (rat K 0)) (unit_row K (length V) 0))))
    (seq 0 (length V)).

(** What w sees of the condition of t, taken with the witness: its value has an inverse. *)
Definition gap (t : tree) (w : vec K) : num :=
  nadd (nadd (dot w (mv (B (M (root t))) (slope M eta t))) (dot w (eta t)))
       (nscale (-1) (dot w (flow u eta t))).

Definition check_not p (t : tree) (w : vec K) (inverse : num) : bool :=
  check M u witness p && check_identity u witness
  && forallb (fun c => check_resolves (V (M c)) (Z c) (a c)) (colours P)
  && ok t && (size t <=? S p) && (length w =? length (V (M (root t))))
  && veq (mv (tr (V (M (root t)))) w) w
  && equal (nmul T (gap t w) inverse) (Rat 1).

Variables (F : field) (roots : list F).
Add Field F_field_n : (laws F).
Hypothesis roots_ok : roots_of F T roots.
Local Notation R := (of_field F).
Local Notation ev := (eval F roots).
Local Notation vm := (@value_m K R ev).
Local Notation vv := (@value_v K R ev).

Ltac hom := intros; first [reflexivity | apply ev_rat | apply ev_add | now apply ev_mul].

Lemma unit_row_hom n i : vv (unit_row K n i) = unit_row R n i.
Proof. unfold unit_row, value_v. rewrite map_map. apply map_ext. intro. apply ev_rat. Qed.

Lemma check_resolves_value W Y y : check_resolves W Y y = true -> resolves (vm W) (vm Y) (vv y).
Proof.
  unfold check_resolves. rewrite !andb_true_iff, forallb_forall. intros [[N S] H].
  split; [|split].
  - rewrite value_length. now apply Nat.ltb_lt.
  - now rewrite value_length, rect_hom.
  - intros i I. rewrite value_length in *. specialize (H i).
    rewrite andb_true_iff in H. destruct H as [L E]; [apply in_seq; lia|].
    apply Nat.eqb_eq in L. apply (@veq_value T F roots) in E.
    assert (Q : nth i (vm Y) [] = vv (nth i Y [])).
    { unfold value_m. change (@nil R) with (vv []). apply map_nth. }
    rewrite Q. split; [unfold value_v; now rewrite map_length|].
    rewrite !(@vadd_hom K R ev), (@mv_hom K R ev), (@scale_hom K R ev), !unit_row_hom in E by hom.
    rewrite (@tr_hom K R ev) in E by hom. rewrite (@nth_hom K R ev) in E by hom. exact E.
Qed.

Theorem check_not_order_identity p t w i : check_not p t w i = true ->
  ~ has_order_identity (@value_of P T M F roots) (S p).
Proof.
  unfold check_not. rewrite !andb_true_iff. intros [[[[[[[C I] H] O] N] L] W] G] [S [v [g [D J]]]].
  rewrite forallb_forall in H. apply Nat.leb_le in N. apply Nat.eqb_eq in L.
  pose proof (@check_starting P T M u witness F roots roots_ok p C) as C'.
  pose proof (@check_identity_value P T M u witness F roots I) as I'.
  assert (Y : forall c, resolves (GLM.V (@value_of P T M F roots c)) (vm (Z c)) (vv (a c))).
  { intro c. apply check_resolves_value, H, colours_all. }
  pose proof (@next_condition P F (@value_of P T M F roots) _ _ S Y _ _ _ _ p t (vv w) C' I' D J O N) as E.
  apply (@veq_value T F roots) in W. rewrite (@mv_hom K R ev), (@tr_hom K R ev) in W by hom.
  specialize (E (eq_trans (map_length _ _) (eq_trans L (eq_sym (map_length _ _)))) W).
  apply (equal_eval F roots) in G. rewrite nmul_eval in G by assumption.
  unfold gap in G. rewrite !nadd_eval, nscale_eval in G.
  rewrite !(@dot_hom K R ev), (@mv_hom K R ev) in G by hom.
  rewrite (@slope_hom K R ev) in G by hom. rewrite (@flow_hom K R ev) in G by hom.
  change (fadd F) with (add R) in G.
  unfold eta in G.
  rewrite (@of_Q_eq F (-1)%Q (- (1))%Q), of_Q_opp in G by reflexivity.
  match type of G with fmul F ?x ?y = _ => assert (Z0 : x = f0 F) end.
  { etransitivity; [apply (f_equal (fun q => fadd F q _)); exact E|]. rewrite of_Q_1.
    match goal with |- ?x = ?y => refine (_ : @eq (element F) x y) end.
    change (add R) with (fadd F). ring. }
  rewrite Z0 in G. cbn [eval] in G. rewrite of_Q_1 in G.
  apply (F_1_neq_0 (laws F)). rewrite <- G. ring.
Qed.
End Check.
