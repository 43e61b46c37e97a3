(** * No explicit symmetric multistep half has parasitic residues that are all 0

    A half of a partitioned multistep method is rho(E) y_n = h sigma(E) f_n with
    rho = (z - zeta_1) .. (z - zeta_k), where 1 is one of the roots, all simple and none 0, and
    sigma = beta_0 + beta_1 z + .. + beta_k z^k. It is symmetric where sigma reads the same
    backwards, explicit where beta_k = 0. Its residue at a root is
    mu(zeta) = sigma(zeta) / (zeta rho'(zeta)), and mu(1) = 1 where it is consistent; a parasitic
    part at zeta of an equation a' = L a obeys a' = mu(zeta) L a to first order in the step.

    The residues at the roots other than 1 have the sum -1. So one of them is not 0, and where they
    are real one is -1/(k-1) or less. *)
From Coq Require Import List Arith Lia Field.
From Glmref Require Import Field.
Import ListNotations.
Set Implicit Arguments.

Section Halves.
Variable F : field.
Add Field F_field : (laws F).
Local Notation "0" := (f0 F).
Local Notation "1" := (f1 F).
Local Infix "+" := (fadd F).
Local Infix "*" := (fmul F).
Local Infix "-" := (fsub F).
Local Infix "/" := (fdiv F).
Local Notation "- x" := (fopp F x).

Definition sum (l : list F) : F := fold_right (fadd F) 0 l.

(** The polynomial with these coefficients, that of z^0 first. *)
Fixpoint polynomial (c : list F) (z : F) : F :=
  match c with [] => 0 | a :: t => a + z * polynomial t z end.

(** (z - zeta_1) .. (z - zeta_k) and its derivative. *)
Fixpoint rho (roots : list F) (z : F) : F :=
  match roots with [] => 1 | a :: t => (z - a) * rho t z end.
Fixpoint rho' (roots : list F) (z : F) : F :=
  match roots with [] => 0 | a :: t => rho t z + (z - a) * rho' t z end.

Definition mu (beta roots : list F) (zeta : F) : F :=
  polynomial beta zeta / (zeta * rho' roots zeta).

Record half (beta roots : list F) : Prop := {
  simple : NoDup roots;
  nonzero : ~ In 0 roots;
  degree : length beta = S (length roots);
  symmetric : rev beta = beta;
  explicit : nth (length roots) beta 0 = 0
}.

(** Proofs from here on. *)

Lemma product_nonzero (x y : F) : x <> 0 -> y <> 0 -> x * y <> 0.
Proof. intros X Y E. apply Y. transitivity (x * y / x); [now field | rewrite E; now field]. Qed.

Lemma one_nonzero : 1 <> 0.
Proof. intro E. apply (char0 F O). simpl. rewrite E. ring. Qed.

Lemma minus_nonzero (x y : F) : x <> y -> x - y <> 0.
Proof. intros H E. apply H. transitivity (x - y + y); [ring | rewrite E; ring]. Qed.

Lemma rho_at_root l z : In z l -> rho l z = 0.
Proof.
  induction l as [|a t IH]; simpl; intros []; [subst; ring | rewrite IH by easy; ring].
Qed.

Lemma rho_nonzero l z : ~ In z l -> rho l z <> 0.
Proof.
  induction l as [|a t IH]; simpl; intro H.
  - exact one_nonzero.
  - apply product_nonzero; [apply minus_nonzero; intro; subst; tauto | tauto].
Qed.

Lemma rho'_nonzero l z : NoDup l -> In z l -> rho' l z <> 0.
Proof.
  induction 1 as [|a t N D IH]; simpl; intros []; intro E.
  - subst a. apply (@rho_nonzero _ _ N). rewrite <- E. ring.
  - rewrite (@rho_at_root t z) in E by easy.
    refine (@product_nonzero (z - a) (rho' t z) (@minus_nonzero z a _) (IH H) _);
      [|rewrite <- E; ring].
    intro; subst; tauto.
Qed.

(** The sum of g(zeta) / rho'(zeta) over the roots: the divided difference of g. *)
Definition difference (l : list F) (g : F -> F) : F := sum (map (fun z => g z / rho' l z) l).

Lemma sum_linear (l : list F) (f g : F -> F) (a b : F) :
  sum (map (fun z => a * f z + b * g z) l) = a * sum (map f l) + b * sum (map g l).
Proof. induction l as [|x t IH]; simpl; [|rewrite IH]; ring. Qed.

Lemma sum_same (l : list F) (f g : F -> F) :
  (forall z, In z l -> f z = g z) -> sum (map f l) = sum (map g l).
Proof. intro H. f_equal. now apply map_ext_in. Qed.

Lemma difference_cons a t g : NoDup (a :: t) ->
  difference (a :: t) g = g a / rho t a + difference t (fun z => g z / (z - a)).
Proof.
  intro D. inversion_clear D as [|? ? N D']. unfold difference. simpl. f_equal.
  - f_equal. ring.
  - apply sum_same. intros z I. rewrite (@rho_at_root t z I).
    assert (z - a <> 0) by (apply minus_nonzero; intro; subst; tauto).
    pose proof (@rho'_nonzero _ _ D' I).
    transitivity (g z / ((z - a) * rho' t z)); [f_equal; ring | now field].
Qed.

(** Of two roots: f[a, b, ..] = (f[a, ..] - f[b, ..]) / (a - b). *)
Lemma difference_two a b t g : NoDup (a :: b :: t) ->
  difference (a :: b :: t) g * (a - b) = difference (a :: t) g - difference (b :: t) g.
Proof.
  intro D. inversion_clear D as [|? ? N D1]. inversion_clear D1 as [|? ? N' D2].
  assert (a <> b) by (intro; subst; apply N; now left).
  assert (~ In a t) by (intro; apply N; now right).
  rewrite !difference_cons by (repeat constructor; easy). simpl.
  assert (E : difference t (fun z => g z / (z - a) / (z - b)) * (a - b)
    = difference t (fun z => g z / (z - a)) - difference t (fun z => g z / (z - b))).
  { unfold difference. transitivity (1 * sum (map (fun z => g z / (z - a) / rho' t z) t)
      + - (1) * sum (map (fun z => g z / (z - b) / rho' t z) t)); [|ring].
    rewrite <- sum_linear.
    transitivity ((a - b) * sum (map (fun z => g z / (z - a) / (z - b) / rho' t z) t)
      + 0 * sum (map (fun z => 0) t)); [ring|].
    rewrite <- sum_linear. apply sum_same. intros z I.
    assert (z - a <> 0) by (apply minus_nonzero; intro; subst; tauto).
    assert (z - b <> 0) by (apply minus_nonzero; intro; subst; tauto).
    pose proof (@rho'_nonzero _ _ D2 I). now field. }
  transitivity (g a / rho t a - g b / rho t b
    + difference t (fun z => g z / (z - a) / (z - b)) * (a - b)); [|rewrite E; ring].
  pose proof (@rho_nonzero _ _ N'). pose proof (@rho_nonzero _ _ H0).
  pose proof (@minus_nonzero _ _ H).
  assert (b - a <> 0) by (apply minus_nonzero; congruence).
  field. repeat split; easy.
Qed.

Lemma difference_one a b t : NoDup (a :: b :: t) -> difference (a :: b :: t) (fun _ => 1) = 0.
Proof.
  revert a b. induction t as [|c t IH]; intros a b D; inversion D as [|? ? N D1]; subst.
  - assert (a - b <> 0) by (apply minus_nonzero; intro; subst; apply N; now left).
    assert (b - a <> 0) by (apply minus_nonzero; intro; subst; apply N; now left).
    assert (A : rho' [a; b] a = a - b) by (simpl; ring).
    assert (B : rho' [a; b] b = b - a) by (simpl; ring).
    unfold difference, sum. cbn [map fold_right]. rewrite A, B. now field.
  - inversion D1 as [|? ? N1 D2]; subst.
    assert (H : a - b <> 0) by (apply minus_nonzero; intro; subst; apply N; now left).
    transitivity (difference (a :: b :: c :: t) (fun _ => 1) * (a - b) / (a - b)); [now field|].
    rewrite difference_two by easy. rewrite !IH; [field; easy| easy |].
    constructor; [intro; apply N; now right | easy].
Qed.

(** Of a polynomial of degree k - 1 or less at k points: its coefficient of z^(k-1). *)
Lemma difference_polynomial c : forall a t, NoDup (a :: t) -> length c <= S (length t) ->
  difference (a :: t) (polynomial c) = nth (length t) c 0.
Proof.
  induction c as [|c0 c IH]; intros a t D L; simpl in L.
  - unfold difference. set (z0 := sum (map (fun _ => 0) (a :: t))).
    transitivity (0 * z0 + 0 * z0).
    + unfold z0. rewrite <- sum_linear. apply sum_same. intros z I. simpl.
      pose proof (@rho'_nonzero _ _ D I). now field.
    + destruct (length t); simpl; ring.
  - transitivity (c0 * difference (a :: t) (fun _ => 1)
      + 1 * (a * difference (a :: t) (polynomial c) + 1 * difference t (polynomial c))).
    + assert (E : difference t (polynomial c)
        = sum (map (fun z => (z - a) * polynomial c z / rho' (a :: t) z) (a :: t))).
      { pose proof (difference_cons (fun z => (z - a) * polynomial c z) D) as E.
        unfold difference at 1 in E. rewrite E. inversion_clear D as [|? ? N D'].
        transitivity (difference t (fun z => (z - a) * polynomial c z / (z - a))).
        - unfold difference. apply sum_same. intros z I.
          assert (z - a <> 0) by (apply minus_nonzero; intro; subst; tauto).
          pose proof (@rho'_nonzero _ _ D' I). now field.
        - pose proof (@rho_nonzero _ _ N). field. easy. }
      rewrite E. unfold difference. rewrite <- !sum_linear. apply sum_same. intros z I.
      pose proof (@rho'_nonzero _ _ D I). simpl polynomial. field. easy.
    + rewrite (IH a t D) by lia. rewrite (nth_overflow c) by lia.
      destruct t as [|b t].
      * destruct c; [|simpl in L; lia]. unfold difference, sum. cbn [map fold_right].
        replace (rho' [a] a) with 1 by (simpl; ring). simpl. field.
        exact one_nonzero.
      * rewrite difference_one by easy. inversion_clear D as [|? ? N D'].
        rewrite IH by (easy || (simpl in *; lia)). simpl. ring.
Qed.

Theorem residues_of_a_half beta roots : half beta roots -> roots <> [] ->
  sum (map (mu beta roots) roots) = 0.
Proof.
  intros [D Z L R X] E. destruct roots as [|a t]; [easy|].
  destruct beta as [|b0 beta]; [discriminate|].
  assert (B : b0 = 0).
  { transitivity (nth 0 (rev (b0 :: beta)) 0); [now rewrite R|].
    rewrite rev_nth by (simpl; lia). rewrite L. simpl. simpl in X.
    replace (length t - 0)%nat with (length t) by lia. easy. }
  simpl in L, X. injection L as L. transitivity (nth (length t) beta 0); [|exact X].
  rewrite <- (@difference_polynomial beta a t) by (easy || lia).
  unfold difference, mu. apply sum_same. intros z I. rewrite B. simpl polynomial.
  assert (z <> 0) by (intro; subst; tauto).
  pose proof (@rho'_nonzero _ _ D I). field. easy.
Qed.

Theorem parasitic_residues beta zetas : half beta (1 :: zetas) -> mu beta (1 :: zetas) 1 = 1 ->
  sum (map (mu beta (1 :: zetas)) zetas) = - (1).
Proof.
  intros H C. pose proof (residues_of_a_half H) as E. simpl in E.
  rewrite C in E. transitivity (1 + sum (map (mu beta (1 :: zetas)) zetas) - 1); [ring|].
  rewrite E; [ring | discriminate].
Qed.

(** Not all parasitic residues are 0. *)
Theorem explicit_symmetric_grows beta zetas : half beta (1 :: zetas) ->
  mu beta (1 :: zetas) 1 = 1 -> ~ forall z, In z zetas -> mu beta (1 :: zetas) z = 0.
Proof.
  intros H C N. pose proof (parasitic_residues H C) as E.
  rewrite (sum_same zetas (mu beta (1 :: zetas)) (fun _ => 0) N) in E.
  assert (Z : sum (map (fun _ : F => 0) zetas) = 0)
    by (clear; induction zetas as [|x t IH]; simpl; [easy | rewrite IH; ring]).
  rewrite Z in E. apply one_nonzero. transitivity (0 - - (1)); [ring | rewrite <- E; ring].
Qed.

Lemma sum_positive (positive : F -> Prop) (g : F -> F) l : l <> [] ->
  (forall x y, positive x -> positive y -> positive (x + y)) ->
  (forall z, In z l -> positive (g z)) -> positive (sum (map g l)).
Proof.
  intros E P N. induction l as [|a [|b t] IH]; [easy| |].
  - simpl. replace (g a + 0) with (g a) by ring. apply N. now left.
  - apply P; [apply N; now left | apply IH; [discriminate|]]. intros z I. apply N. now right.
Qed.

Lemma sum_ones (l : list F) : sum (map (fun _ => 1) l) = of_nat F (length l).
Proof. induction l as [|x t IH]; [easy|]. simpl. rewrite IH. reflexivity. Qed.

(** Where "positive" is any property that sums inherit and 0 has not, not all parasitic residues
    exceed -1/(k - 1) by something positive. *)
Theorem explicit_symmetric_least beta zetas (positive : F -> Prop) :
  half beta (1 :: zetas) -> mu beta (1 :: zetas) 1 = 1 ->
  ~ positive 0 -> (forall x y, positive x -> positive y -> positive (x + y)) ->
  ~ forall z, In z zetas -> positive (mu beta (1 :: zetas) z + 1 / of_nat F (length zetas)).
Proof.
  intros H C P0 PA N. pose proof (parasitic_residues H C) as E.
  assert (L : zetas <> []).
  { intro Z. rewrite Z in E. apply one_nonzero. transitivity (0 - - (1)); [ring|].
    rewrite <- E. simpl. ring. }
  assert (M : of_nat F (length zetas) <> 0)
    by (destruct zetas as [|b t]; [easy | exact (char0 F (length t))]).
  apply P0. pose proof (@sum_positive positive _ zetas L PA N) as S. revert S.
  assert (T : sum (map (fun z => mu beta (1 :: zetas) z + 1 / of_nat F (length zetas)) zetas) = 0).
  { transitivity (1 * sum (map (mu beta (1 :: zetas)) zetas)
      + 1 / of_nat F (length zetas) * sum (map (fun _ => 1) zetas)).
    - rewrite <- sum_linear. apply sum_same. intros. ring.
    - rewrite E, sum_ones. now field. }
  now rewrite T.
Qed.

(** There are such halves: of y_(n+2) - y_n = 2 h f_(n+1) the parasitic residue is -1. *)
Example leapfrog : half [0; 1 + 1; 0] [1; - (1)] /\ mu [0; 1 + 1; 0] [1; - (1)] 1 = 1
  /\ mu [0; 1 + 1; 0] [1; - (1)] (- (1)) = - (1).
Proof.
  assert (two : 1 + 1 <> 0)
    by (intro E; apply (char0 F 1); simpl; transitivity (1 + 1); [ring | exact E]).
  assert (P : forall z, polynomial [0; 1 + 1; 0] z = (1 + 1) * z) by (intro; simpl; ring).
  assert (R : forall z, rho' [1; - (1)] z = (1 + 1) * z) by (intro; simpl; ring).
  assert (M : - (1) <> 0)
    by (intro E; apply one_nonzero; transitivity (- - (1)); [ring | rewrite E; ring]).
  pose proof one_nonzero as N. unfold mu. rewrite !P, !R. split; [split; simpl; try easy|].
  - repeat constructor; simpl; [|tauto]. intros [E|[]]. apply two.
    transitivity (1 + - (1)); [now rewrite E | ring].
  - tauto.
  - split; now field.
Qed.
End Halves.

Print Assumptions explicit_symmetric_grows.
Print Assumptions explicit_symmetric_least.
