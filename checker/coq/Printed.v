(** * The method of order 6 that a thesis prints does not exist

    Khan (2018), section 3.4, prints A and b of a G-symplectic method with four values, with
    G = diag(1, -1/2, -1/2, 1) and D = diag(b), b the first row of B. The identity
    D A + A^T D = B^T G B asks b_i a_ij + a_ji b_j - b_i b_j to be a sum of three products
    g_k B_ki B_kj, a matrix of rank 3 at most. Whatever G = diag(1, g2, g3, g4) and whatever the
    other rows of B, in any field of characteristic zero, that is impossible. *)
From Coq Require Import List Arith Lia QArith Field.
From Glmref Require Import Trees Field GLM Symplectic.
Import ListNotations.
Local Open Scope nat_scope.

Section Determinant.
Variable R : numbers.
Local Notation "a + b" := (add R a b).
Local Notation "a * b" := (mul R a b).
Definition minus (a b : R) := a + rat R (-1) * b.
Definition det3 (w : nat -> nat -> R) i j k a b c : R :=
  minus (w i a * minus (w j b * w k c) (w j c * w k b)
         + w i c * minus (w j a * w k b) (w j b * w k a))
        (w i b * minus (w j a * w k c) (w j c * w k a)).
Definition det4 (w : nat -> nat -> R) i j k l a b c d : R :=
  minus (minus (w i a * det3 w j k l b c d + w i c * det3 w j k l a b d)
               (w i b * det3 w j k l a c d)) (w i d * det3 w j k l a b c).
End Determinant.

Definition printed_b : list Q := [-17 # 168; 3375 # 9464; 248 # 507; 3375 # 9464; -17 # 168].
Definition printed_A : list (list Q) :=
  [[0%Q; 0%Q; 0%Q; 0%Q; 0%Q];
   [1 # 30; 1 # 30; 0%Q; 0%Q; 0%Q];
   [691 # 105; 29 # 4; 1 # 30; 0%Q; 0%Q];
   [-16684847 # 263250; 8363191 # 114075; 100688 # 10125; 1 # 30; 0%Q];
   [1310159 # 6630; -658732 # 2873; 1413104 # 43095; -675 # 5746; 0%Q]].

Section Printed.
Variable F : field.
Add Field F_field : (laws F).
Local Notation R := (of_field F).
Local Infix "+" := (add R).
Local Infix "*" := (mul R).

Definition b i : R := rat R (nth i printed_b 0%Q).
Definition a i j : R := rat R (nth j (nth i printed_A []) 0%Q).

(** b_i a_ij + a_ji b_j - b_i b_j, first as rational numbers *)
Definition left (i j : nat) : number (in_tower []) :=
  let b i := Rat (nth i printed_b 0%Q) in
  let a i j := Rat (nth j (nth i printed_A []) 0%Q) in
  let m := mul (in_tower []) in
  let s := add (in_tower []) in
  s (s (m (b i) (a i j)) (m (a j i) (b j))) (m (Rat (-1)) (m (b i) (b j))).

Lemma no_rank_3 (x1 x2 x3 y1 y2 y3 : nat -> R) i j k l p q r s :
  det4 R (fun m n => x1 m * y1 n + x2 m * y2 n + x3 m * y3 n) i j k l p q r s = rat R 0.
Proof.
  unfold det4, det3, minus. simpl.
  rewrite (@of_Q_eq F (-1)%Q (- (1))%Q), of_Q_opp, of_Q_1, of_Q_0 by reflexivity.
  change (number R) with (element F) in *. ring.
Qed.

Theorem printed_order_6_does_not_exist (g2 g3 g4 : R) (B2 B3 B4 : nat -> R) :
  ~ forall i j, i < 5 -> j < 5 ->
    b i * a i j + a j i * b j
    = b i * b j + g2 * B2 i * B2 j + g3 * B3 i * B3 j + g4 * B4 i * B4 j.
Proof.
  intro H.
  assert (E : forall i j, i < 5 -> j < 5 -> eval F [] (left i j)
    = (g2 * B2 i) * B2 j + (g3 * B3 i) * B3 j + (g4 * B4 i) * B4 j).
  { intros i j I J. unfold left. cbv zeta. rewrite !ev_add, !ev_mul by exact Logic.I. simpl eval.
    fold (b i) (b j). specialize (H i j I J). unfold a, b in *. simpl in *. rewrite H.
    rewrite (@of_Q_eq F (-1)%Q (- (1))%Q), of_Q_opp, of_Q_1 by reflexivity. ring. }
  pose proof (no_rank_3 (fun i => g2 * B2 i) (fun i => g3 * B3 i) (fun i => g4 * B4 i) B2 B3 B4
    0 1 2 3 0 1 2 3) as D.
  assert (G : eval F [] (det4 (in_tower []) left 0 1 2 3 0 1 2 3) = rat R 0).
  { rewrite <- D. unfold det4, det3, minus.
    repeat first [rewrite ev_add | rewrite ev_mul by exact Logic.I].
    rewrite ?E by lia. reflexivity. }
  set (d := det4 (in_tower []) left 0 1 2 3 0 1 2 3) in G.
  apply (@invertible [] F [] Logic.I d (Rat (/ constant d)%Q)); [vm_compute; reflexivity | exact G].
Qed.
End Printed.

Print Assumptions printed_order_6_does_not_exist.
