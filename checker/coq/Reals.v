(** * The theorems hold for the real numbers of Coq

    This is the only file that uses axioms: those with which Coq's standard library builds the real
    numbers. Nothing else depends on it. *)
From Coq Require Import Reals Lra List.
From Glmref Require Import Field.
Import ListNotations.
Local Open Scope R_scope.

Lemma R_char0 n : Nat.iter (S n) (Rplus 1) 0 <> 0.
Proof.
  assert (H : forall n, 0 <= Nat.iter n (Rplus 1) 0) by (clear; induction n; simpl; lra).
  specialize (H n). simpl. lra.
Qed.

Definition reals : field :=
  {| element := R; f0 := 0; f1 := 1; fadd := Rplus; fmul := Rmult; fsub := Rminus;
     fopp := Ropp; fdiv := Rdiv; finv := Rinv; laws := Rfield; char0 := R_char0 |}.

(** sqrt 3 is a root of the tower of many methods, N and Gauss 2 among them. *)
Lemma sqrt_3_root : roots_of reals [(2%nat, Rat (QArith_base.Qmake 3 1))] [sqrt 3].
Proof.
  split; [intros _ | exact Logic.I]. unfold power. simpl. unfold of_Q, of_Z, of_nat. simpl.
  rewrite Rmult_1_r, sqrt_sqrt by lra. field.
Qed.
