(** * G-symplecticity, time-reversal symmetry, growth of parasitic components

    All are identities between matrices. Transposes are plain ones: for complex methods they are
    to be read in their real form. *)
From Coq Require Import List Arith Lia Bool QArith Field.
From Glmref Require Import Trees Field GLM.
Import ListNotations.
Set Implicit Arguments.
Local Open Scope nat_scope.

Section Matrices.
Variable R : numbers.
Local Notation mat := (mat R).
Local Notation vec := (vec R).

Definition col j (M : mat) : vec := map (fun row => nth j row (rat R 0)) M.
Definition columns n (M : mat) : mat := map (fun j => col j M) (seq 0 n).
Definition tr (M : mat) : mat := columns (length (hd [] M)) M.
Definition mm (M N : mat) : mat := map (fun row => mv (tr N) row) M.
Definition mopp (M : mat) : mat := map (scale (rat R (-1))) M.
Fixpoint madd (M N : mat) : mat := match M, N with
  | x :: M', y :: N' => vadd x y :: madd M' N' | _, _ => [] end.
Fixpoint dm (D : vec) (M : mat) : mat := match D, M with      (* diag(D) M *)
  | d :: D', x :: M' => scale d x :: dm D' M' | _, _ => [] end.
Definition unit_row n i : vec := map (fun j => rat R (if i =? j then 1 else 0)) (seq 0 n).
Definition eye n : mat := map (unit_row n) (seq 0 n).
Definition outer (u y : vec) : mat := map (fun a => scale a y) u.

(** Rows and columns in another order. *)
Definition rows (P : list nat) (M : mat) : mat := map (fun i => nth i M []) P.
Definition cols (P : list nat) (M : mat) : mat :=
  map (fun row => map (fun j => nth j row (rat R 0)) P) M.
End Matrices.
Local Infix "**" := (@mm _) (at level 40, left associativity).

Section Definitions.
Variable R : numbers.

Definition well_shaped (m : glm R) : bool := shaped (P := rooted) (fun _ => m).

(** A Runge-Kutta method carries one value. *)
Definition rk (A : mat R) (b : vec R) : glm R :=
  {| A := A; U := map (fun _ => [rat R 1]) b; B := [b]; V := [[rat R 1]]; slopes := length b |}.

(** G = V^T G V,  D U = B^T G V,  D A + A^T D = B^T G B,  G symmetric.
    Then every quadratic invariant y^T Q y is carried exactly by sum g_ij y_i^T Q y_j. *)
Definition form (m : glm R) (G : mat R) (D : vec R) : Prop :=
  rect (length (V m)) (length (V m)) G = true /\ length D = length (A m) /\ tr G = G /\
  G = tr (V m) ** G ** V m /\
  dm D (U m) = tr (B m) ** G ** V m /\
  madd (dm D (A m)) (tr (dm D (A m))) = tr (B m) ** G ** B m.

(** .. with a form that sees the solution: u^T G u is not 0, where V u = u, U u = 1. *)
Definition g_symplectic (m : glm R) : Prop :=
  well_shaped m = true /\ exists G D u, form m G D /\
  mv (V m) u = u /\ mv (U m) u = ones R (length (U m)) /\ dot u (mv G u) <> rat R 0.

(** The method equals its adjoint, up to an involution L of the values and P of the stages:
    L^2 = I,  L V^-1 L = V,  B = V L B P,  U = P U L V,  A + P A P = U V^-1 B. *)
Definition symmetric (m : glm R) : Prop :=
  well_shaped m = true /\ exists (L W : mat R) (P : list nat),
  rect (length (V m)) (length (V m)) L = true /\ rect (length (V m)) (length (V m)) W = true /\
  length P = length (A m) /\ map (fun i => nth i P 0) P = seq 0 (length (A m)) /\
  V m ** W = eye R (length (V m)) /\ L ** L = eye R (length (V m)) /\ L ** W ** L = V m /\
  B m = V m ** L ** cols P (B m) /\ U m = rows P (U m ** L ** V m) /\
  madd (A m) (rows P (cols P (A m))) = U m ** W ** B m.

(** Every growth parameter is 0, whatever other eigenvalues than 1 there are: w B U v = 0 for left
    and right eigenvectors. *)
Definition no_growth (m : glm R) : Prop :=
  well_shaped m = true /\
  forall (zeta : R) (w v : vec R), length w = length (V m) -> length v = length (V m) ->
  mv (V m) v = scale zeta v -> mv (tr (V m)) w = scale zeta w -> zeta <> rat R 1 ->
  dot w (mv (B m) (mv (U m) v)) = rat R 0.

(** Pairs q' = f(p), p' = k(q) (stages Q = h A f(P) + U q, P = h A^ k(Q) + U^ p): bilinear
    invariants q^T S p are carried by sum g_ij q_i^T S p_j.
    V^T G V^ = G,  D_P U^ = B^T G V^,  D_Q U = B^^T G^T V,  D_P A^ + A^T D_Q = B^T G B^.
    Where f and k depend on both variables ([joint]) there is one D. *)
Definition pair_form (q p : glm R) (G : mat R) (DP DQ : vec R) : Prop :=
  rect (length (V q)) (length (V p)) G = true /\
  length DP = length (A p) /\ length DQ = length (A q) /\
  G = tr (V q) ** G ** V p /\
  dm DP (U p) = tr (B q) ** G ** V p /\
  dm DQ (U q) = tr (B p) ** tr G ** V q /\
  madd (dm DP (A p)) (tr (dm DQ (A q))) = tr (B q) ** G ** B p.
Definition pair_g_symplectic (joint : bool) (q p : glm R) : Prop :=
  exists G DP DQ u v, pair_form q p G DP DQ /\ (joint = true -> DP = DQ) /\
  mv (V q) u = u /\ mv (U q) u = ones R (length (U q)) /\
  mv (V p) v = v /\ mv (U p) v = ones R (length (U p)) /\ dot u (mv G v) <> rat R 0.
End Definitions.

(** * Proofs from here on *)

Section Hom.
Variables (K R : numbers) (h : K -> R).
Hypothesis h_rat : forall q, h (rat K q) = rat R q.
Hypothesis h_add : forall x y, h (add K x y) = add R (h x) (h y).
Hypothesis h_mul : forall x y, h (mul K x y) = mul R (h x) (h y).
Local Notation vm := (@value_m K R h).
Local Notation vv := (@value_v K R h).

Lemma nth_hom j x : h (nth j x (rat K 0)) = nth j (vv x) (rat R 0).
Proof. rewrite <- h_rat. unfold value_v. now rewrite map_nth. Qed.

Lemma col_hom j M : vv (col j M) = col j (vm M).
Proof.
  unfold col, value_m, value_v. rewrite !map_map. apply map_ext. intro. apply nth_hom.
Qed.

Lemma tr_hom M : vm (tr M) = tr (vm M).
Proof.
  unfold tr, columns. replace (length (hd [] (vm M))) with (length (hd [] M)).
  - unfold value_m at 1. rewrite map_map. apply map_ext. intro. apply col_hom.
  - destruct M; simpl; auto. unfold value_v. now rewrite map_length.
Qed.

Lemma mm_hom M N : vm (M ** N) = vm M ** vm N.
Proof.
  unfold mm. transitivity (map (fun row => mv (tr (vm N)) (vv row)) M).
  - unfold value_m at 1. rewrite map_map. apply map_ext. intro row.
    rewrite (@mv_hom K R h) by assumption. now rewrite tr_hom.
  - change (vm M) with (map vv M). now rewrite map_map.
Qed.

Lemma madd_hom M N : vm (madd M N) = madd (vm M) (vm N).
Proof.
  revert N; induction M as [|x M IH]; intros [|y N]; simpl; auto.
  rewrite IH. f_equal. now apply vadd_hom.
Qed.

Lemma dm_hom D M : vm (dm D M) = dm (vv D) (vm M).
Proof.
  revert M; induction D as [|d D IH]; intros [|x M]; simpl; auto.
  rewrite IH. f_equal. now apply scale_hom.
Qed.

Lemma mopp_hom M : vm (mopp M) = mopp (vm M).
Proof.
  unfold mopp, value_m. rewrite !map_map. apply map_ext. intro x.
  rewrite <- h_rat. now apply scale_hom.
Qed.

Lemma outer_hom u y : vm (outer u y) = outer (vv u) (vv y).
Proof.
  transitivity (map (fun a => scale (h a) (vv y)) u).
  - unfold outer, value_m. rewrite map_map. apply map_ext. intro. now apply scale_hom.
  - unfold outer. change (vv u) with (map h u). now rewrite map_map.
Qed.

Lemma eye_hom n : vm (eye K n) = eye R n.
Proof.
  unfold eye, value_m. rewrite map_map. apply map_ext. intro i. unfold unit_row, value_v.
  rewrite map_map. apply map_ext. auto.
Qed.

Lemma rows_hom P M : vm (rows P M) = rows P (vm M).
Proof.
  unfold rows, value_m. rewrite map_map. apply map_ext. intro i.
  change (@nil R) with (vv []). now rewrite map_nth.
Qed.

Lemma cols_hom P M : vm (cols P M) = cols P (vm M).
Proof.
  unfold cols, value_m, value_v. rewrite !map_map. apply map_ext. intro row.
  rewrite map_map. apply map_ext. intro. apply nth_hom.
Qed.
End Hom.

(** ** Why B U = V X - X V + u y^T leaves no growth *)

Unset Implicit Arguments.
Section Bilinear.
Variable F : field.
Add Field F_field_b : (laws F).
Local Notation R := (of_field F).
Local Notation vec := (vec R).
Local Notation mat := (mat R).
Local Notation "0" := (rat R 0).

Ltac fring := simpl; rewrite ?of_Q_0;
  match goal with |- ?a = ?b => change (@eq (element F) a b) end; ring.

Lemma dot_vadd (w x y : vec) : length x = length y ->
  dot w (vadd x y) = add R (dot w x) (dot w y).
Proof.
  revert x y; induction w as [|a w IH]; intros [|b x] [|c y] H; try discriminate;
    unfold dot, vmul, vadd in *; simpl in *; try fring.
  rewrite IH by lia. fring.
Qed.

Lemma dot_scale a (w x : vec) : dot w (scale a x) = mul R a (dot w x).
Proof.
  revert x; induction w as [|b w IH]; intros [|c x]; unfold dot, vmul, scale in *; simpl in *;
    try fring. rewrite IH. fring.
Qed.

Lemma dot_comm (x y : vec) : dot x y = dot y x.
Proof. unfold dot, vmul. now rewrite (zip_comm (F := F)) by (intros; fring). Qed.

Lemma rect_rows n k (M : mat) : rect n k M = true -> length M = n /\ forall x, In x M -> length x = k.
Proof.
  unfold rect. rewrite andb_true_iff, forallb_forall. intros [H G]. apply Nat.eqb_eq in H.
  split; auto. intros x I. apply Nat.eqb_eq. auto.
Qed.

Lemma add_row a (f : nat -> R) (x : vec) : forall i,
  map (fun j => add R (mul R (nth (j - i) x 0) a) (f j)) (seq i (length x))
  = vadd (scale a x) (map f (seq i (length x))).
Proof.
  unfold vadd. induction x as [|b x IH]; intro i; simpl; auto. f_equal.
  - rewrite Nat.sub_diag. fring.
  - rewrite <- IH. apply map_ext_in. intros j J. apply in_seq in J.
    destruct (j - i)%nat eqn:D; [lia|]. now replace n with (j - S i)%nat by lia.
Qed.

(** (w M) v = w (M v) *)
Lemma adjoint k (M : mat) : (forall x, In x M -> length x = k) ->
  forall w v : vec, length w = length M -> length v = k ->
  dot (mv (columns k M) w) v = dot w (mv M v).
Proof.
  intro H. induction M as [|x M IH]; intros [|a w] v Hw Hv; try discriminate.
  - assert (Z : forall l : list nat, dot (mv (map (fun j => col j ([] : mat)) l) []) v = f0 F).
    { intro l. revert v Hv. clear. revert k. induction l as [|j l IH]; intros k v Hv.
      - unfold dot; simpl. apply of_Q_0.
      - destruct v as [|b v]; [apply of_Q_0|]. simpl. unfold dot, vmul in *; simpl.
        specialize (IH (length v) v eq_refl). simpl in IH. rewrite IH. fring. }
    unfold columns. rewrite Z. unfold dot; simpl. symmetry. apply of_Q_0.
  - assert (E : mv (columns k (x :: M)) (a :: w) = vadd (scale a x) (mv (columns k M) w)).
    { rewrite <- (H x) by now left. unfold columns, mv. rewrite !map_map. rewrite <- (add_row a _ x 0%nat).
      apply map_ext. intro j. rewrite Nat.sub_0_r. reflexivity. }
    rewrite E. cbn [mv map]. rewrite dot_comm, dot_vadd.
    + rewrite dot_scale, (dot_comm v x), (dot_comm v (mv _ w)), IH; auto.
      intros y I. apply H. now right.
    + unfold scale, mv, columns. rewrite !map_length, seq_length. apply H. now left.
Qed.

Lemma tr_columns (n k : nat) (M : mat) : rect n k M = true -> (0 < n)%nat -> tr M = columns k M.
Proof.
  intros H N. apply rect_rows in H. destruct H as [L H]. unfold tr.
  destruct M as [|x M]; simpl in *; [lia|]. now rewrite (H x) by now left.
Qed.

Lemma mv_mm n k (M N : mat) v : rect n k N = true -> (0 < n)%nat -> length v = k ->
  (forall x, In x M -> length x = n) -> mv (M ** N) v = mv M (mv N v).
Proof.
  intros HN P Hv HM. unfold mm, mv at 1 3. rewrite map_map. apply map_ext_in. intros x I.
  rewrite (tr_columns _ _ _ HN P). apply rect_rows in HN. destruct HN as [L H].
  apply adjoint; auto. rewrite L. auto.
Qed.

Lemma mv_scale (M : mat) a v : mv M (scale a v) = scale a (mv M v).
Proof. unfold mv, scale at 2. rewrite map_map. apply map_ext. intro. apply dot_scale. Qed.

Lemma mm_rows n k (M N : mat) : rect n k N = true -> (0 < n)%nat ->
  forall x, In x (M ** N) -> length x = k.
Proof.
  intros H N0 x I. unfold mm in I. apply in_map_iff in I. destruct I as [y [<- _]].
  unfold mv. rewrite map_length, (tr_columns _ _ _ H N0). unfold columns. now rewrite map_length, seq_length.
Qed.

Lemma mv_madd k v (M : mat) : forall N : mat, (forall x, In x M -> length x = k) ->
  (forall x, In x N -> length x = k) -> mv (madd M N) v = vadd (mv M v) (mv N v).
Proof.
  induction M as [|x M IH]; intros [|y N] HM HN; simpl; auto. unfold vadd at 2. simpl. f_equal.
  - rewrite !(dot_comm _ v). apply dot_vadd. rewrite (HM x), (HN y); auto; now left.
  - apply IH; intros; [apply HM | apply HN]; now right.
Qed.

Lemma mv_mopp (M : mat) v : mv (mopp M) v = scale (rat R (-1)) (mv M v).
Proof.
  unfold mv, mopp, scale at 2. rewrite !map_map. apply map_ext. intro x.
  now rewrite (dot_comm _ v), dot_scale, (dot_comm v).
Qed.

Lemma mv_outer (u y v : vec) : mv (outer u y) v = scale (dot y v) u.
Proof.
  unfold mv, outer, scale at 2. rewrite map_map. apply map_ext. intro a.
  rewrite (dot_comm _ v), dot_scale, (dot_comm v). fring.
Qed.

Lemma vadd_length n : forall x y : vec, length x = n -> length y = n -> length (vadd x y) = n.
Proof.
  unfold vadd. induction n as [|n IH]; intros [|a x] [|b y] Hx Hy; simpl in *; auto; lia.
Qed.

Lemma only_zero (z d : F) : z <> f1 F -> fmul F z d = d -> d = f0 F.
Proof.
  intros Z E. assert (D : fsub F (f1 F) z <> f0 F).
  { intro D. apply Z. transitivity (fsub F (f1 F) (fsub F (f1 F) z)); [ring | rewrite D; ring]. }
  transitivity (fmul F (finv F (fsub F (f1 F) z)) (fsub F d (fmul F z d))); [field; exact D|].
  rewrite E. ring.
Qed.

Lemma commutator_no_growth (m : glm R) (X : mat) (u y : vec) : well_shaped m = true ->
  rect (length (V m)) (length (V m)) X = true -> (0 < length (A m))%nat ->
  length u = length (V m) -> length y = length (V m) -> mv (V m) u = u ->
  B m ** U m = madd (madd (V m ** X) (mopp (X ** V m))) (outer u y) -> no_growth m.
Proof.
  intros S HX P Hu Hy Eu E. split; auto. intros zeta w v Hw Hv Ev Ew Z.
  unfold well_shaped, shaped in S. cbn [colours rooted forallb] in S.
  rewrite !andb_true_iff in S. destruct S as [[[[[SA SU] SB] SV] [SS _]] _].
  cbn in SS. apply Nat.eqb_eq in SS. rewrite <- SS in SB.
  destruct (V m) as [|r0 Vt] eqn:EV; [destruct w; [reflexivity | discriminate]|].
  rewrite <- EV in *. assert (Q : (0 < length (V m))%nat) by (rewrite EV; simpl; lia).
  set (r := length (V m)) in *.
  pose proof (proj2 (rect_rows _ _ _ HX)) as RX. pose proof (proj2 (rect_rows _ _ _ SV)) as RV.
  rewrite <- (mv_mm _ _ _ _ v SU P Hv (proj2 (rect_rows _ _ _ SB))), E.
  pose proof (mm_rows _ _ (V m) _ HX Q) as R1. pose proof (mm_rows _ _ X _ SV Q) as R2.
  assert (R3 : forall x, In x (mopp (X ** V m)) -> length x = r).
  { intros x I. unfold mopp in I. apply in_map_iff in I. destruct I as [z [<- I]].
    unfold scale. rewrite map_length. auto. }
  rewrite mv_madd with (k := r), mv_madd with (k := r), mv_mopp, mv_outer; auto.
  2:{ clear - R1 R3. revert R1 R3. generalize (mopp (X ** V m)). generalize (V m ** X).
      intro M. induction M as [|a M IH]; intros [|b N] HM HN x I; simpl in I; try contradiction.
      destruct I as [<-|I].
      - apply vadd_length; [apply HM | apply HN]; now left.
      - apply (IH N); auto; intros; [apply HM | apply HN]; now right. }
  2:{ intros x I. unfold outer in I. apply in_map_iff in I. destruct I as [z [<- _]].
      unfold scale. now rewrite map_length. }
  rewrite !(mv_mm r r) by auto.
  assert (W : forall x, length x = r -> dot w (mv (V m) x) = mul R zeta (dot w x)).
  { intros x Hx. rewrite <- (adjoint r) by auto.
    rewrite <- (tr_columns _ _ _ SV Q), Ew. rewrite !(dot_comm _ x). apply dot_scale. }
  assert (LX : length (mv X v) = r).
  { unfold mv. rewrite map_length. exact (proj1 (rect_rows _ _ _ HX)). }
  assert (U0 : @eq F (dot w u) (f0 F)).
  { apply (only_zero zeta); [intro D; apply Z; rewrite D; symmetry; apply of_Q_1|].
    pose proof (W u Hu) as G. rewrite Eu in G. symmetry. exact G. }
  assert (LV : forall x, length (mv (V m) x) = r) by (intro; unfold mv; now rewrite map_length).
  rewrite dot_vadd, dot_vadd, !dot_scale, W, Ev, mv_scale, dot_scale, U0; auto.
  - simpl. rewrite (@of_Q_eq F (-1)%Q (- (1))%Q), of_Q_opp, of_Q_1 by reflexivity. fring.
  - unfold scale. rewrite map_length, LV. unfold mv. rewrite !map_length.
    symmetry. exact (proj1 (rect_rows _ _ _ HX)).
  - unfold scale at 2. rewrite map_length, Hu. unfold scale.
    apply vadd_length; auto. rewrite map_length. unfold mv. rewrite map_length.
    exact (proj1 (rect_rows _ _ _ HX)).
Qed.
End Bilinear.
Set Implicit Arguments.

(** ** The checks *)

Section Check.
Variable T : tower.
Local Notation K := (in_tower T).

Fixpoint meq (M N : list (list num)) : bool := match M, N with
  | [], [] => true
  | x :: M', y :: N' => veq x y && meq M' N'
  | _, _ => false end.

Definition check_form (m : glm K) (G : mat K) (D : vec K) : bool :=
  rect (length (V m)) (length (V m)) G && (length D =? length (A m)) && meq (tr G) G
  && meq G (tr (V m) ** G ** V m)
  && meq (dm D (U m)) (tr (B m) ** G ** V m)
  && meq (madd (dm D (A m)) (tr (dm D (A m)))) (tr (B m) ** G ** B m).

(** [i] is the inverse of u^T G u. *)
Definition check_g (m : glm K) (G : mat K) (D u : vec K) (i : num) : bool :=
  well_shaped m && check_form m G D && veq (mv (V m) u) u
  && veq (mv (U m) u) (ones K (length (U m))) && equal (nmul T (dot u (mv G u)) i) (Rat 1).

Definition check_symmetric (m : glm K) (L W : mat K) (P : list nat) : bool :=
  well_shaped m
  && rect (length (V m)) (length (V m)) L && rect (length (V m)) (length (V m)) W
  && (length P =? length (A m))
  && (if list_eq_dec Nat.eq_dec (map (fun i => nth i P 0) P) (seq 0 (length (A m)))
      then true else false)
  && meq (V m ** W) (eye K (length (V m))) && meq (L ** L) (eye K (length (V m)))
  && meq (L ** W ** L) (V m) && meq (B m) (V m ** L ** cols P (B m))
  && meq (U m) (rows P (U m ** L ** V m))
  && meq (madd (A m) (rows P (cols P (A m)))) (U m ** W ** B m).

(** [X], [y] with B U = V X - X V + u y^T, V u = u. *)
Definition check_growth (m : glm K) (X : mat K) (u y : vec K) : bool :=
  let r := length (V m) in
  well_shaped m && rect r r X && (0 <? length (A m)) && (length u =? r) && (length y =? r)
  && veq (mv (V m) u) u
  && meq (B m ** U m) (madd (madd (V m ** X) (mopp (X ** V m))) (outer u y)).

Definition check_pair_form (q p : glm K) (G : mat K) (DP DQ : vec K) : bool :=
  rect (length (V q)) (length (V p)) G
  && (length DP =? length (A p)) && (length DQ =? length (A q))
  && meq G (tr (V q) ** G ** V p)
  && meq (dm DP (U p)) (tr (B q) ** G ** V p)
  && meq (dm DQ (U q)) (tr (B p) ** tr G ** V q)
  && meq (madd (dm DP (A p)) (tr (dm DQ (A q)))) (tr (B q) ** G ** B p).

Definition check_pair_g joint (q p : glm K) (G : mat K) (DP DQ u v : vec K) (i : num) : bool :=
  check_pair_form q p G DP DQ && implb joint (veq DP DQ)
  && veq (mv (V q) u) u && veq (mv (U q) u) (ones K (length (U q)))
  && veq (mv (V p) v) v && veq (mv (U p) v) (ones K (length (U p)))
  && equal (nmul T (dot u (mv G v)) i) (Rat 1).

Variables (F : field) (roots : list F).
Hypothesis roots_ok : roots_of F T roots.
Add Field F_field : (laws F).
Local Notation R := (of_field F).
Local Notation ev := (eval F roots).
Local Notation vm := (@value_m K R ev).
Local Notation vv := (@value_v K R ev).
Local Notation vg := (@value K R ev).

Ltac hom := first [assumption | reflexivity | apply ev_rat | apply ev_add | now apply ev_mul].
Ltac push := repeat first
  [ rewrite mm_hom by hom | rewrite tr_hom by hom | rewrite madd_hom by hom
  | rewrite dm_hom by hom | rewrite eye_hom by hom | rewrite rows_hom by hom
  | rewrite cols_hom by hom | rewrite mopp_hom by hom | rewrite outer_hom by hom
  | rewrite (@mv_hom K R ev) by hom | rewrite (@ones_hom K R ev) by hom ].
Ltac push_in H := repeat first
  [ rewrite mm_hom in H by hom | rewrite tr_hom in H by hom | rewrite madd_hom in H by hom
  | rewrite dm_hom in H by hom | rewrite eye_hom in H by hom | rewrite rows_hom in H by hom
  | rewrite cols_hom in H by hom | rewrite mopp_hom in H by hom | rewrite outer_hom in H by hom
  | rewrite (@mv_hom K R ev) in H by hom | rewrite (@ones_hom K R ev) in H by hom ].

Lemma meq_value M N : meq M N = true -> vm M = vm N.
Proof.
  revert N; induction M as [|x M IH]; intros [|y N] H; try discriminate; auto.
  simpl in *. apply andb_true_iff in H. f_equal; [apply veq_value | apply IH]; tauto.
Qed.

Lemma invertible x i : equal (nmul T x i) (Rat 1) = true -> ev x <> rat R 0.
Proof.
  intros E Z. apply (equal_eval F roots) in E. rewrite nmul_eval, Z in E by assumption.
  simpl in E. rewrite of_Q_0, of_Q_1 in E. apply (F_1_neq_0 (laws F)). rewrite <- E. ring.
Qed.

Lemma well_shaped_value m : well_shaped m = true -> well_shaped (vg m) = true.
Proof. intro H. unfold well_shaped in *. now rewrite <- H, <- (@shaped_hom K R ev). Qed.

Ltac split_all := repeat match goal with
  | H : _ && _ = true |- _ => apply andb_true_iff in H; destruct H
  | H : (_ =? _) = true |- _ => apply Nat.eqb_eq in H
  | H : meq _ _ = true |- _ => apply meq_value in H
  | H : veq _ _ = true |- _ => apply (veq_value T F roots) in H
  end.
Ltac lengths := unfold value_m, value_v; rewrite ?map_length; assumption.

Lemma check_form_value m G D : check_form m G D = true -> form (vg m) (vm G) (vv D).
Proof.
  unfold check_form. intro C. split_all.
  repeat match goal with H : vm _ = vm _ |- _ => progress push_in H end.
  unfold form, value. cbn [A U B V slopes].
  repeat split; try assumption.
  - rewrite rect_hom, value_length. assumption.
  - lengths.
Qed.

Theorem check_g_symplectic m G D u i : check_g m G D u i = true -> g_symplectic (vg m).
Proof.
  unfold check_g. intro C. split_all. split; [now apply well_shaped_value|].
  exists (vm G), (vv D), (vv u).
  repeat match goal with H : vv _ = vv _ |- _ => progress push_in H end.
  split; [now apply check_form_value|]. unfold value. cbn [A U B V slopes].
  rewrite value_length. repeat split; try assumption.
  rewrite <- (@mv_hom K R ev), <- (@dot_hom K R ev) by hom. eapply invertible. eassumption.
Qed.

Theorem check_symmetric_value m L W P : check_symmetric m L W P = true -> symmetric (vg m).
Proof.
  unfold check_symmetric. intro C. split_all.
  destruct (list_eq_dec _ _ _) as [E|E]; [|discriminate].
  repeat match goal with H : vm _ = vm _ |- _ => progress push_in H end.
  split; [now apply well_shaped_value|]. exists (vm L), (vm W), P.
  unfold value. cbn [A U B V slopes]. rewrite !rect_hom, !value_length.
  repeat split; assumption.
Qed.

(** w V X v - w X V v = zeta w X v - w X v zeta = 0, and w u = w V u = zeta w u makes w u = 0. *)
Theorem check_no_growth m X u y : check_growth m X u y = true -> no_growth (vg m).
Proof.
  unfold check_growth. intro C. split_all.
  match goal with H : (0 <? _) = true |- _ => apply Nat.ltb_lt in H end.
  repeat match goal with H : vm _ = vm _ |- _ => progress push_in H
                       | H : vv _ = vv _ |- _ => progress push_in H end.
  split; [now apply well_shaped_value|].
  match goal with H : well_shaped m = true |- _ => apply well_shaped_value in H end.
  apply (commutator_no_growth F (vg m) (vm X) (vv u) (vv y)); unfold value; cbn [A U B V slopes];
    rewrite ?value_length, ?rect_hom; try assumption; lengths.
Qed.

Theorem check_pair_g_symplectic joint q p G DP DQ u v i :
  check_pair_g joint q p G DP DQ u v i = true -> pair_g_symplectic joint (vg q) (vg p).
Proof.
  unfold check_pair_g, check_pair_form. intro C. split_all.
  repeat match goal with H : vm _ = vm _ |- _ => progress push_in H
                       | H : vv _ = vv _ |- _ => progress push_in H end.
  match goal with H : implb joint _ = true |- _ => rename H into J end.
  assert (joint = true -> vv DP = vv DQ).
  { intros ->. simpl in J. now apply (veq_value T F roots) in J. }
  exists (vm G), (vv DP), (vv DQ), (vv u), (vv v).
  unfold pair_form, value. cbn [A U B V slopes]. rewrite !rect_hom, !value_length.
  repeat split; try assumption; try lengths.
  rewrite <- (@mv_hom K R ev), <- (@dot_hom K R ev) by hom. eapply invertible. eassumption.
Qed.
End Check.
