(** * Rooted trees, and the exact flow as a series over them

    A tree is built by grafting (Butcher's product): [graft t s] hangs the tree [s] on the root of
    [t] as one more branch. Every tree is a root with branches grafted on it, one after another;
    two trees that differ only in the order of branches are the [same] tree. Vertices have a
    colour: one colour for y' = f(y), two for q' = f(q, p), p' = k(q, p). *)
From Coq Require Import List Arith Lia Bool PArith.
Import ListNotations.
Set Implicit Arguments.

(** Which colours there are, and which colour may stand under which. *)
Record palette := {
  colour :> Type;
  code : colour -> nat;
  code_inj : forall a b, code a = code b -> a = b;
  colours : list colour;
  colours_all : forall c, In c colours;
  edge : colour -> colour -> bool              (* parent, child *)
}.

Section Trees.
Variable P : palette.

Inductive tree := leaf (c : P) | graft (t s : tree).

Fixpoint root t := match t with leaf c => c | graft t _ => root t end.

(** Order: the number of vertices. *)
Fixpoint size t := match t with leaf _ => 1 | graft t s => size t + size s end.

(** Density: the product of the orders of the subtrees at all vertices. *)
Fixpoint below t : positive :=
  match t with leaf _ => 1 | graft t s => below t * (Pos.of_nat (size s) * below s) end.
Definition density t : positive := Pos.of_nat (size t) * below t.

(** Colours are allowed along every edge. *)
Fixpoint ok t : bool :=
  match t with leaf _ => true | graft t s => ok t && ok s && edge _ (root t) (root s) end.

(** The order of the branches does not matter. *)
Inductive same : tree -> tree -> Prop :=
| same_refl t : same t t
| same_sym t s : same t s -> same s t
| same_trans t s r : same t s -> same s r -> same t r
| same_graft t t' s s' : same t t' -> same s s' -> same (graft t s) (graft t' s')
| same_swap t a b : same (graft (graft t a) b) (graft (graft t b) a).

Lemma same_root t s : same t s -> root t = root s.
Proof. induction 1; simpl; congruence. Qed.

Lemma same_size t s : same t s -> size t = size s.
Proof. induction 1; simpl; lia. Qed.

Lemma same_below t s : same t s -> below t = below s.
Proof.
  induction 1 as [| | |t t' s s' _ IHt H IHs|]; simpl; try congruence.
  - now rewrite IHt, IHs, (same_size H).
  - rewrite <- !(Pos.mul_assoc (below t)). f_equal. apply Pos.mul_comm.
Qed.

Lemma same_density t s : same t s -> density t = density s.
Proof. intro H. unfold density. now rewrite (same_below H), (same_size H). Qed.

Lemma same_ok t s : same t s -> ok t = ok s.
Proof.
  induction 1 as [| | |t t' s s' Ht IHt Hs IHs|]; simpl; try congruence.
  - now rewrite IHt, IHs, (same_root Ht), (same_root Hs).
  - destruct (ok t), (ok a), (ok b), (edge P (root t) (root a)); simpl;
      now destruct (edge P (root t) (root b)).
Qed.

(** ** One tree for each class: branches in ascending order *)

Fixpoint cmp t s : comparison :=
  match t, s with
  | leaf c, leaf d => Nat.compare (code _ c) (code _ d)
  | leaf _, graft _ _ => Lt
  | graft _ _, leaf _ => Gt
  | graft a b, graft c d => match cmp b d with Eq => cmp a c | x => x end
  end.

Lemma cmp_refl t : cmp t t = Eq.
Proof. induction t; simpl; [apply Nat.compare_refl | now rewrite IHt2]. Qed.

Lemma cmp_eq t s : cmp t s = Eq -> t = s.
Proof.
  revert s; induction t as [c|a IHa b IHb]; destruct s as [d|x y]; simpl; try discriminate.
  - intro H. apply Nat.compare_eq, code_inj in H. congruence.
  - destruct (cmp b y) eqn:H; try discriminate. intro. f_equal; auto.
Qed.

Lemma cmp_sym t s : cmp s t = CompOpp (cmp t s).
Proof.
  revert s; induction t as [c|a IHa b IHb]; destruct s as [d|x y]; simpl; auto.
  - apply Nat.compare_antisym.
  - rewrite IHb. destruct (cmp b y); simpl; auto.
Qed.

Lemma cmp_trans t s r : cmp t s = Lt -> cmp s r = Lt -> cmp t r = Lt.
Proof.
  revert s r; induction t as [c|a IHa b IHb]; destruct s as [d|x y], r as [e|v w]; simpl;
    try discriminate; auto.
  - rewrite !Nat.compare_lt_iff. lia.
  - destruct (cmp b y) eqn:H; destruct (cmp y w) eqn:K; try discriminate; intros.
    + apply cmp_eq in H, K. subst. rewrite cmp_refl. eauto.
    + apply cmp_eq in H. subst. now rewrite K.
    + apply cmp_eq in K. subst. now rewrite H.
    + now rewrite (IHb _ _ H K).
Qed.

Definition leb t s := match cmp t s with Gt => false | _ => true end.

Lemma leb_total t s : leb t s = false -> leb s t = true.
Proof. unfold leb. rewrite (cmp_sym t s). now destruct (cmp t s). Qed.

Lemma leb_antisym t s : leb t s = true -> leb s t = true -> t = s.
Proof.
  unfold leb. rewrite (cmp_sym t s). destruct (cmp t s) eqn:H; try discriminate.
  intros. now apply cmp_eq.
Qed.

Lemma leb_trans t s r : leb t s = true -> leb s r = true -> leb t r = true.
Proof.
  unfold leb. destruct (cmp t s) eqn:H; destruct (cmp s r) eqn:K; try discriminate; intros _ _.
  - apply cmp_eq in H, K. subst. now rewrite cmp_refl.
  - apply cmp_eq in H. subst. now rewrite K.
  - apply cmp_eq in K. subst. now rewrite H.
  - now rewrite (cmp_trans _ _ _ H K).
Qed.

Definition eqb t s := match cmp t s with Eq => true | _ => false end.

Lemma eqb_eq t s : eqb t s = true -> t = s.
Proof. unfold eqb. destruct (cmp t s) eqn:H; try discriminate. intros _. now apply cmp_eq. Qed.

Fixpoint insert x t :=
  match t with
  | leaf _ => graft t x
  | graft t' y => if leb y x then graft t x else graft (insert x t') y
  end.

Fixpoint canon t := match t with leaf c => leaf c | graft t s => insert (canon s) (canon t) end.

Lemma insert_swap a b t : insert a (insert b t) = insert b (insert a t).
Proof.
  assert (D : forall u, (if leb b a then graft (graft u b) a else graft (graft u a) b)
                      = (if leb a b then graft (graft u a) b else graft (graft u b) a)).
  { intro u. destruct (leb b a) eqn:H, (leb a b) eqn:K; auto.
    - now rewrite (leb_antisym _ _ H K).
    - apply leb_total in H. congruence. }
  induction t as [c|t IH y _]; simpl; [apply D|].
  destruct (leb y b) eqn:H, (leb y a) eqn:K; simpl; rewrite ?H, ?K; auto.
  - destruct (leb b a) eqn:X; auto. rewrite (leb_trans _ _ _ H X) in K. discriminate.
  - destruct (leb a b) eqn:X; auto. rewrite (leb_trans _ _ _ K X) in H. discriminate.
  - now rewrite IH.
Qed.

Lemma same_canon_eq t s : same t s -> canon t = canon s.
Proof. induction 1; simpl; try congruence. apply insert_swap. Qed.

Lemma insert_same x t : same (insert x t) (graft t x).
Proof.
  induction t as [c|t IH y _]; simpl; [apply same_refl|].
  destruct (leb y x); [apply same_refl|].
  eapply same_trans; [apply same_graft; [apply IH|apply same_refl] | apply same_swap].
Qed.

Lemma canon_same t : same (canon t) t.
Proof.
  induction t as [c|t IHt s IHs]; simpl; [apply same_refl|].
  eapply same_trans; [apply insert_same | now apply same_graft].
Qed.

(** ** The list of all trees *)

Definition last_le t s := match t with leaf _ => true | graft _ y => leb y s end.
Definition fits t s := edge _ (root t) (root s) && last_le t s.

Fixpoint sorted t : bool :=
  match t with leaf _ => true | graft t s => sorted t && sorted s && last_le t s end.

(** [levels n] lists the trees of order n, .., 2, 1. *)
Definition next (ls : list (list tree)) : list tree :=
  flat_map (fun p => flat_map (fun t => map (graft t) (filter (fits t) (snd p))) (fst p))
           (combine ls (rev ls)).
Fixpoint levels n : list (list tree) :=
  match n with
  | 0 => []
  | 1 => [map leaf (colours P)]
  | S m => let ls := levels m in next ls :: ls
  end.
Definition trees p : list tree := concat (rev (levels p)).

Lemma insert_sorted x t : sorted x = true -> sorted t = true -> sorted (insert x t) = true.
Proof.
  intro X. induction t as [c|t IH y _]; simpl; [now rewrite X|].
  rewrite !andb_true_iff. intros [[T Y] L]. destruct (leb y x) eqn:H; simpl.
  - now rewrite T, Y, L, X, H.
  - rewrite IH, Y by assumption. simpl. destruct t as [c|t z]; simpl in *.
    + now apply leb_total.
    + destruct (leb z x); simpl; auto. now apply leb_total.
Qed.

Lemma canon_sorted t : sorted (canon t) = true.
Proof. induction t; simpl; auto. now apply insert_sorted. Qed.

Lemma size_pos t : 1 <= size t.
Proof. induction t; simpl; lia. Qed.

Lemma levels_length n : length (levels n) = n.
Proof. induction n as [|[|n] IH]; simpl in *; auto. Qed.

Lemma levels_complete n t : sorted t = true -> ok t = true -> size t <= n ->
  In t (nth (n - size t) (levels n) []).
Proof.
  revert t; induction n as [|n IH]; intros t Ht O N; [pose proof (size_pos t); lia|].
  destruct n as [|n].
  - destruct t as [c|t s]; simpl in *; [|pose proof (size_pos t); pose proof (size_pos s); lia].
    apply in_map, colours_all.
  - change (levels (S (S n))) with (next (levels (S n)) :: levels (S n)).
    destruct (Nat.eq_dec (size t) (S (S n))) as [E|E].
    2:{ replace (S (S n) - size t) with (S (S n - size t)) by lia. apply IH; auto; lia. }
    rewrite E, Nat.sub_diag. cbn [nth]. destruct t as [c|t s]; [simpl in E; lia|].
    cbn [sorted ok size] in *. rewrite !andb_true_iff in Ht, O.
    destruct Ht as [[St Ss] L], O as [[Ot Os] C].
    pose proof (size_pos t); pose proof (size_pos s).
    apply in_flat_map.
    exists (nth (S n - size t) (levels (S n)) [], nth (S n - size s) (levels (S n)) []). split.
    + replace (nth (S n - size s) (levels (S n)) [])
        with (nth (S n - size t) (rev (levels (S n))) []).
      2:{ rewrite rev_nth; rewrite levels_length; [f_equal; lia | lia]. }
      rewrite <- combine_nth; [|now rewrite rev_length].
      apply nth_In. rewrite combine_length, rev_length, levels_length. lia.
    + cbn [fst snd]. apply in_flat_map. exists t. split; [apply IH; auto; lia|].
      apply in_map, filter_In. split; [apply IH; auto; lia|].
      unfold fits. now rewrite C, L.
Qed.

(** The list is complete: it holds the canonical form of every tree of order p or less. *)
Theorem trees_complete p t : ok t = true -> size t <= p -> In (canon t) (trees p).
Proof.
  intros O N. apply in_concat. pose proof (canon_same t) as C.
  rewrite <- (same_ok C) in O. rewrite <- (same_size C) in N.
  exists (nth (p - size (canon t)) (levels p) []). split.
  - apply -> in_rev. apply nth_In. rewrite levels_length. pose proof (size_pos (canon t)). lia.
  - apply levels_complete; auto using canon_sorted.
Qed.

(** ** Recursion over trees with a memory *)

Section Fold.
Variables (X : Type) (one : P -> X) (join : tree -> X -> X -> X).

Fixpoint fold t := match t with leaf c => one c | graft t s => join s (fold t) (fold s) end.

Definition get (tab : list (tree * X)) t :=
  match find (fun e => eqb (fst e) t) tab with Some e => snd e | None => fold t end.
Definition step tab t :=
  (t, match t with leaf c => one c | graft t s => join s (get tab t) (get tab s) end) :: tab.
Definition table ts := fold_left step ts [].

Definition right tab := forall e, In e tab -> snd e = fold (fst e).

Lemma get_right tab t : right tab -> get tab t = fold t.
Proof.
  intro R. unfold get. destruct (find _ tab) as [e|] eqn:H; auto.
  apply find_some in H. destruct H as [I E]. apply eqb_eq in E. now rewrite (R _ I), E.
Qed.

Lemma step_right tab t : right tab -> right (step tab t).
Proof.
  intros R e [<-|I]; [|now apply R]. simpl. destruct t; simpl; auto. now rewrite !get_right.
Qed.

Lemma table_in ts t : In t ts -> In (t, fold t) (table ts).
Proof.
  unfold table. enough (H : forall tab, right tab -> (In t ts \/ In (t, fold t) tab) ->
    In (t, fold t) (fold_left step ts tab)) by (intro; apply H; auto; intros ? []).
  induction ts as [|s ts IH]; simpl; intros tab R [I|I]; auto; try contradiction.
  - destruct I as [<-|I]; apply IH; auto using step_right.
    right. left. pose proof (@step_right tab s R _ (or_introl eq_refl)) as Q.
    simpl in Q |- *. now rewrite Q.
  - apply IH; auto using step_right. right. now right.
Qed.
End Fold.
End Trees.

(** ** The three palettes *)

Definition rooted : palette.
Proof.
  refine {| colour := unit; code _ := 0; colours := [tt]; edge _ _ := true |};
    intros; repeat match goal with x : unit |- _ => destruct x end; simpl; auto.
Defined.

Definition two (e : bool -> bool -> bool) : palette.
Proof.
  refine {| colour := bool; code c := if c then 1 else 0; colours := [false; true]; edge := e |};
    intros; repeat match goal with x : bool |- _ => destruct x end; simpl in *; auto; discriminate.
Defined.

(** q' = f(q, p), p' = k(q, p): [false] is f and [true] is k. *)
Definition general := two (fun _ _ => true).
(** q' = f(p), p' = k(q): colours alternate. *)
Definition separable := two xorb.

(** As many trees as there should be (Butcher 2016, table 301(II)). *)
Definition count P n := length (hd [] (levels P n)).
Example rooted_counts : map (count rooted) (seq 1 10) = [1; 1; 2; 4; 9; 20; 48; 115; 286; 719].
Proof. vm_compute. reflexivity. Qed.
Example separable_counts : map (count separable) (seq 1 8) = [2; 2; 4; 8; 18; 40; 96; 230].
Proof. vm_compute. reflexivity. Qed.
Example general_counts : map (count general) (seq 1 6) = [2; 4; 14; 52; 214; 916].
Proof. vm_compute. reflexivity. Qed.
