(** * Numbers: any field of characteristic zero, and a field to compute in

    Theorems are stated for every field F of characteristic zero (the real and the complex numbers
    are two of them) and for all elements of F that satisfy the equations of the roots that the
    coefficients contain, such as x^2 = 3. So no real number is constructed, and it does not matter
    which of the two roots x is.

    Proofs compute with [num]: rational numbers, and polynomials in roots, reduced by
    root^n = radicand. [eval] takes such a number to its value in F. *)
From Coq Require Import List Arith Lia Bool ZArith QArith Field.
Import ListNotations.
Set Implicit Arguments.
Local Open Scope nat_scope.

(** Numbers that methods are made of: rational ones, sums, products. *)
Record numbers := { number :> Type; rat : Q -> number; add : number -> number -> number;
                    mul : number -> number -> number }.

Record field := {
  element :> Type;
  f0 : element; f1 : element;
  fadd : element -> element -> element; fmul : element -> element -> element;
  fsub : element -> element -> element; fopp : element -> element;
  fdiv : element -> element -> element; finv : element -> element;
  laws : field_theory f0 f1 fadd fmul fsub fopp fdiv finv eq;
  char0 : forall n, Nat.iter (S n) (fadd f1) f0 <> f0
}.

Section Values.
Variable F : field.
Add Field F_field : (laws F).

(** 1 + 1 + .. + 1, and the rational numbers of F. *)
Definition of_nat n : F := Nat.iter n (fadd F (f1 F)) (f0 F).
Definition of_Z z : F := match z with
  | Z0 => f0 F | Zpos p => of_nat (Pos.to_nat p) | Zneg p => fopp F (of_nat (Pos.to_nat p)) end.
Definition of_Q (q : Q) : F := fdiv F (of_Z (Qnum q)) (of_nat (Pos.to_nat (Qden q))).

Definition of_field : numbers :=
  {| number := F; rat := of_Q; add := fadd F; mul := fmul F |}.

Lemma of_nat_add a b : of_nat (a + b) = fadd F (of_nat a) (of_nat b).
Proof. induction a; unfold of_nat in *; simpl; [ring | rewrite IHa; ring]. Qed.

Lemma of_nat_mul a b : of_nat (a * b) = fmul F (of_nat a) (of_nat b).
Proof.
  induction a; simpl; [unfold of_nat; simpl; ring|].
  rewrite of_nat_add, IHa. unfold of_nat; simpl. ring.
Qed.

Lemma of_Z_sub a b : of_Z (Z.of_nat a - Z.of_nat b) = fsub F (of_nat a) (of_nat b).
Proof.
  destruct (le_lt_dec b a) as [H|H].
  - replace a with ((a - b) + b) at 2 by lia. rewrite of_nat_add, <- Nat2Z.inj_sub by lia.
    transitivity (of_nat (a - b)); [|ring].
    destruct (a - b) as [|n]; simpl; [reflexivity|]. now rewrite SuccNat2Pos.id_succ.
  - replace b with ((b - a) + a) at 2 by lia. rewrite of_nat_add.
    replace (Z.of_nat a - Z.of_nat b)%Z with (- Z.of_nat (b - a))%Z by lia.
    transitivity (fopp F (of_nat (b - a))); [|ring].
    destruct (b - a) as [|n] eqn:E; simpl; [lia|]. now rewrite SuccNat2Pos.id_succ.
Qed.

Lemma Z_sub z : exists a b, z = (Z.of_nat a - Z.of_nat b)%Z.
Proof. exists (Z.to_nat z), (Z.to_nat (- z)). lia. Qed.

Lemma of_Z_add x y : of_Z (x + y) = fadd F (of_Z x) (of_Z y).
Proof.
  destruct (Z_sub x) as [a [b ->]], (Z_sub y) as [c [d ->]].
  replace (_ + _)%Z with (Z.of_nat (a + c) - Z.of_nat (b + d))%Z by lia.
  rewrite !of_Z_sub, !of_nat_add. ring.
Qed.

Lemma of_Z_mul x y : of_Z (x * y) = fmul F (of_Z x) (of_Z y).
Proof.
  destruct (Z_sub x) as [a [b ->]], (Z_sub y) as [c [d ->]].
  replace (_ * _)%Z with (Z.of_nat (a * c + b * d) - Z.of_nat (a * d + b * c))%Z by nia.
  rewrite !of_Z_sub, !of_nat_add, !of_nat_mul. ring.
Qed.

Lemma of_pos_nonzero p : of_nat (Pos.to_nat p) <> f0 F.
Proof. destruct (Pos2Nat.is_succ p) as [n ->]. apply char0. Qed.

Lemma of_Q_eq x y : (x == y)%Q -> of_Q x = of_Q y.
Proof.
  unfold Qeq, of_Q. intro H. apply (f_equal of_Z) in H. rewrite !of_Z_mul in H. simpl in H.
  field_simplify_eq; [|split; apply of_pos_nonzero].
  rewrite H. ring.
Qed.

Lemma of_Q_add x y : of_Q (x + y) = fadd F (of_Q x) (of_Q y).
Proof.
  unfold of_Q, Qplus. simpl. rewrite of_Z_add, !of_Z_mul, Pos2Nat.inj_mul, of_nat_mul. simpl.
  field. split; apply of_pos_nonzero.
Qed.

Lemma of_Q_mul x y : of_Q (x * y) = fmul F (of_Q x) (of_Q y).
Proof.
  unfold of_Q, Qmult. simpl. rewrite of_Z_mul, Pos2Nat.inj_mul, of_nat_mul.
  field. split; apply of_pos_nonzero.
Qed.

Lemma of_Q_0 : of_Q 0 = f0 F.
Proof.
  change (of_Q 0) with (fdiv F (f0 F) (of_nat (Pos.to_nat 1))). field. apply of_pos_nonzero.
Qed.

Lemma of_Q_1 : of_Q 1 = f1 F.
Proof.
  assert (H : fdiv F (of_nat (Pos.to_nat 1)) (of_nat (Pos.to_nat 1)) = f1 F)
    by (field; apply of_pos_nonzero).
  exact H.
Qed.

Lemma of_Q_opp x : of_Q (- x) = fopp F (of_Q x).
Proof.
  assert (H : of_Q (x + - x) = f0 F) by (rewrite <- of_Q_0; apply of_Q_eq; ring).
  rewrite of_Q_add in H. transitivity (fsub F (fadd F (of_Q x) (of_Q (- x))) (of_Q x)); [ring|].
  rewrite H. ring.
Qed.
End Values.

(** ** Rational numbers in lowest terms *)

Definition qadd (x y : Q) : Q :=
  match x, y with
  | Qmake Z0 _, _ => y
  | _, Qmake Z0 _ => x
  | Qmake a 1, Qmake b 1 => Qmake (a + b) 1
  | _, _ => Qred (x + y)
  end.

Definition qmul (x y : Q) : Q :=
  match x, y with
  | Qmake Z0 _, _ => Qmake 0 1
  | _, Qmake Z0 _ => Qmake 0 1
  | Qmake 1 1, _ => y
  | _, Qmake 1 1 => x
  | Qmake a 1, Qmake b 1 => Qmake (a * b) 1
  | _, _ => Qred (x * y)
  end.

Lemma qadd_correct x y : (qadd x y == x + y)%Q.
Proof.
  destruct x as [[|a|a] [b|b|]], y as [[|c|c] [d|d|]]; unfold qadd;
    rewrite ?Qred_correct; try reflexivity; unfold Qeq, Qplus; cbn [Qnum Qden];
    rewrite ?Pos2Z.inj_mul; ring.
Qed.

Lemma qmul_correct x y : (qmul x y == x * y)%Q.
Proof.
  destruct x as [[|[a|a|]|[a|a|]] [b|b|]], y as [[|[c|c|]|[c|c|]] [d|d|]]; unfold qmul;
    rewrite ?Qred_correct; try reflexivity; unfold Qeq, Qmult; cbn [Qnum Qden];
    rewrite ?Pos2Z.inj_mul; ring.
Qed.

(** ** Polynomials in roots

    [Ext a b] is a + x b: x is the root of this level, a lies in the levels below, and b is again
    a polynomial in x. A rational number is a number of every level. *)
Inductive num := Rat (q : Q) | Ext (a b : num).

Definition zero := Rat 0.

Fixpoint is_zero x := match x with
  | Rat q => match Qnum q with Z0 => true | _ => false end
  | Ext a b => is_zero a && is_zero b end.

Definition ext a b := match a, b with
  | Rat p, Rat q => match Qnum q with Z0 => Rat p | _ => Ext a b end
  | _, _ => Ext a b end.

Fixpoint nadd_q p y := match y with
  | Rat q => Rat (qadd p q)
  | Ext a b => ext (nadd_q p a) b end.

Fixpoint nadd x y := match x, y with
  | Rat p, _ => nadd_q p y
  | Ext _ _, Rat q => nadd_q q x
  | Ext a b, Ext c d => ext (nadd a c) (nadd b d) end.

Fixpoint nscale p y := match y with
  | Rat q => Rat (qmul p q)
  | Ext a b => ext (nscale p a) (nscale p b) end.

(** low + x^k high *)
Fixpoint split k y := match k, y with
  | O, _ => (zero, y)
  | S _, Rat _ => (y, zero)
  | S k, Ext a b => let (low, high) := split k b in (ext a low, high) end.

Fixpoint constant x := match x with Rat q => q | Ext a _ => constant a end.

(** A tower of roots, the last one first: x^n = d, or nothing known of x where n = 0. *)
Definition tower := list (nat * num).

Section Level.
Variables (m : num -> num -> num) (n : nat) (d : num).   (* the product below; x^n = d *)

Fixpoint lift_mul a y := match y with              (* a is of the levels below *)
  | Rat q => ext (nscale q a) zero
  | Ext c e => ext (m a c) (lift_mul a e) end.

Definition mul_by a y := match a with
  | Rat q => match Qnum q with Z0 => zero | _ => nscale q y end
  | _ => lift_mul a y end.

Definition shift y := match y with
  | Rat q => match Qnum q with Z0 => zero | _ => Ext zero y end
  | _ => match n with
    | O => Ext zero y
    | S k => let (low, high) := split k y in
             if is_zero high then ext zero low else nadd (ext zero low) (mul_by d high) end end.

Fixpoint level_mul x y := match x with
  | Rat p => mul_by x y
  | Ext a b => nadd (mul_by a y) (shift (level_mul b y)) end.
End Level.

Fixpoint nmul (T : tower) x y := match T with
  | [] => Rat (qmul (constant x) (constant y))
  | (n, d) :: T' => level_mul (nmul T') n d x y end.

Definition in_tower (T : tower) : numbers :=
  {| number := num; rat := Rat; add := nadd; mul := nmul T |}.

(** ** The value of a number *)

Section Eval.
Variable F : field.
Add Field F_field' : (laws F).
Local Notation "0" := (f0 F).
Local Infix "+" := (fadd F).
Local Infix "*" := (fmul F).

Fixpoint eval (roots : list F) x : F := match x with
  | Rat q => of_Q F q
  | Ext a b => eval (tl roots) a + hd 0 roots * eval roots b end.

Definition power (x : F) n := Nat.iter n (fmul F x) (f1 F).

(** The roots satisfy the equations of the tower. *)
Fixpoint roots_of (T : tower) (roots : list F) : Prop := match T, roots with
  | [], [] => True
  | (n, d) :: T', x :: roots' => (n <> O -> power x n = eval roots' d) /\ roots_of T' roots'
  | _, _ => False end.

Lemma is_zero_eval roots x : is_zero x = true -> eval roots x = 0.
Proof.
  revert roots; induction x as [[[|p|p] q]|a IHa b IHb]; simpl; intros roots H; try discriminate.
  - rewrite <- of_Q_0. apply of_Q_eq. reflexivity.
  - apply andb_true_iff in H. rewrite IHa, IHb by tauto. ring.
Qed.

Lemma zero_eval roots : eval roots zero = 0.
Proof. now apply is_zero_eval. Qed.

Lemma ext_eval roots a b : eval roots (ext a b) = eval (tl roots) a + hd 0 roots * eval roots b.
Proof.
  destruct a as [p|], b as [[[|x|x] y]|]; simpl; auto.
  rewrite (@of_Q_eq F (0 # y) 0%Q), of_Q_0 by reflexivity. ring.
Qed.

Lemma nadd_q_eval p y : forall roots, eval roots (nadd_q p y) = of_Q F p + eval roots y.
Proof.
  induction y as [q|a IHa b _]; simpl; intro roots.
  - rewrite <- of_Q_add. apply of_Q_eq, qadd_correct.
  - rewrite ext_eval, IHa. ring.
Qed.

Lemma nadd_eval x y : forall roots, eval roots (nadd x y) = eval roots x + eval roots y.
Proof.
  revert y; induction x as [p|a IHa b IHb]; intros y roots; [apply nadd_q_eval|].
  destruct y as [q|c d]; cbn [nadd].
  - rewrite nadd_q_eval. simpl. ring.
  - rewrite ext_eval, IHa, IHb. simpl. ring.
Qed.

Lemma nscale_eval p y : forall roots, eval roots (nscale p y) = of_Q F p * eval roots y.
Proof.
  induction y as [q|a IHa b IHb]; simpl; intro roots.
  - rewrite <- of_Q_mul. apply of_Q_eq, qmul_correct.
  - rewrite ext_eval, IHa, IHb. ring.
Qed.

Lemma split_eval roots k : forall y,
  eval roots y = eval roots (fst (split k y)) + power (hd 0 roots) k * eval roots (snd (split k y)).
Proof.
  induction k as [|k IH]; intros [q|a b]; cbn [split fst snd].
  - rewrite zero_eval. simpl. ring.
  - rewrite zero_eval. simpl. ring.
  - rewrite zero_eval. ring.
  - specialize (IH b). destruct (split k b) as [low high]. cbn [fst snd] in *.
    rewrite ext_eval. simpl eval at 1. rewrite IH. simpl. ring.
Qed.

Section LevelEval.
Variables (m : num -> num -> num) (n : nat) (d : num) (roots : list F).
Hypothesis m_eval : forall a b, eval (tl roots) (m a b) = eval (tl roots) a * eval (tl roots) b.
Hypothesis root : n <> O -> power (hd 0 roots) n = eval (tl roots) d.

Lemma lift_mul_eval a y : eval roots (lift_mul m a y) = eval (tl roots) a * eval roots y.
Proof.
  induction y as [q|c _ e IH]; simpl; rewrite ext_eval.
  - rewrite nscale_eval, zero_eval. ring.
  - rewrite m_eval, IH. ring.
Qed.

Lemma mul_by_eval a y : eval roots (mul_by m a y) = eval (tl roots) a * eval roots y.
Proof.
  destruct a as [[[|p|p] q]|a b]; [| | |apply lift_mul_eval]; unfold mul_by; cbn [Qnum].
  - rewrite zero_eval. cbn [eval]. rewrite (@of_Q_eq F (0 # q) 0%Q), of_Q_0 by reflexivity. ring.
  - apply nscale_eval.
  - apply nscale_eval.
Qed.

Lemma shift_ext y : eval roots (Ext zero y) = hd 0 roots * eval roots y.
Proof. cbn [eval]. rewrite zero_eval. ring. Qed.

Lemma shift_eval y : eval roots (shift m n d y) = hd 0 roots * eval roots y.
Proof.
  assert (G : eval roots (match n with
    | O => Ext zero y
    | S k => let (low, high) := split k y in
             if is_zero high then ext zero low else nadd (ext zero low) (mul_by m d high) end)
    = hd 0 roots * eval roots y).
  { destruct n as [|k]; [apply shift_ext|]. rewrite (split_eval roots k y).
    destruct (split k y) as [low high]. cbn [fst snd].
    destruct (is_zero high) eqn:Z.
    - rewrite ext_eval, zero_eval, (is_zero_eval roots _ Z). ring.
    - rewrite nadd_eval, ext_eval, zero_eval, mul_by_eval, <- root by discriminate.
      unfold power. simpl. ring. }
  destruct y as [q|a b]; [|exact G]. unfold shift. destruct (Qnum q) as [|p|p] eqn:Z.
  - rewrite zero_eval, (is_zero_eval roots (Rat q)); [ring | simpl; now rewrite Z].
  - apply shift_ext.
  - apply shift_ext.
Qed.

Lemma level_mul_eval x y : eval roots (level_mul m n d x y) = eval roots x * eval roots y.
Proof.
  induction x as [p|a _ b IH]; cbn [level_mul].
  - rewrite mul_by_eval. reflexivity.
  - rewrite nadd_eval, mul_by_eval, shift_eval, IH. simpl. ring.
Qed.
End LevelEval.

Lemma constant_eval x : eval [] x = of_Q F (constant x).
Proof. induction x as [|a IHa b _]; simpl in *; [reflexivity | rewrite IHa; ring]. Qed.

Lemma nmul_eval T roots : roots_of T roots ->
  forall x y, eval roots (nmul T x y) = eval roots x * eval roots y.
Proof.
  revert roots; induction T as [|[n d] T IH]; intros [|r roots] H x y; try contradiction.
  - rewrite !constant_eval, <- of_Q_mul. apply of_Q_eq, qmul_correct.
  - destruct H as [R H]. simpl. apply level_mul_eval; auto.
Qed.

Definition equal x y := is_zero (nadd x (nscale (-1) y)).

Lemma equal_eval roots x y : equal x y = true -> eval roots x = eval roots y.
Proof.
  intro H. apply (is_zero_eval roots) in H. rewrite nadd_eval, nscale_eval in H.
  rewrite (@of_Q_eq F (-1)%Q (- (1))%Q), of_Q_opp, of_Q_1 in H by reflexivity.
  transitivity (eval roots x + fopp F (f1 F) * eval roots y + eval roots y); [|rewrite H]; ring.
Qed.
End Eval.

(** ** The rational numbers are such a field, so the theorems about methods with rational
    coefficients speak of something. [Reals.v] does the same for the real numbers. *)
From Coq Require Import Qcanon.

Lemma Qc_char0 n : Nat.iter (S n) (Qcplus 1) (Q2Qc 0) <> Q2Qc 0.
Proof.
  enough (H : forall n, (Q2Qc 0 <= Nat.iter n (Qcplus 1) (Q2Qc 0))%Qc).
  { simpl. intro E. specialize (H n). apply (Qcle_not_lt _ _ H).
    apply Qclt_minus_iff. set (s := Nat.iter n (Qcplus 1) (Q2Qc 0)) in *.
    replace (Q2Qc 0 + - s)%Qc with (1 + s + - s)%Qc by (rewrite E; ring).
    replace (1 + s + - s)%Qc with 1%Qc by ring. reflexivity. }
  clear n. intro n. induction n as [|n IH]; simpl; [apply Qcle_refl|].
  apply (Qcle_trans _ _ _ IH). apply Qcle_minus_iff.
  set (s := Nat.iter n _ _). replace (1 + s + - s)%Qc with 1%Qc by ring. discriminate.
Qed.

Definition rationals : field :=
  {| element := Qc; f0 := Q2Qc 0; f1 := 1%Qc; fadd := Qcplus; fmul := Qcmult; fsub := Qcminus;
     fopp := Qcopp; fdiv := Qcdiv; finv := Qcinv; laws := Qcft; char0 := Qc_char0 |}.
