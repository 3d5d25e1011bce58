; A household robot: the hall can be cleaned for sure, and the cupboard holds a surprise for the cat.
(define (domain household)
  (:requirements :typing :negative-preconditions :non-deterministic)
  (:types room thing)
  (:constants tin ball - thing)
  (:predicates (at ?x - room) (door ?x ?y - room) (cupboard ?x - room) (closed) (has ?t - thing)
    (clean ?x - room) (fed) (played))
  (:action move
    :parameters (?x ?y - room)
    :precondition (and (at ?x) (door ?x ?y))
    :effect (and (not (at ?x)) (at ?y)))
  ; Mopping may have to be repeated.
  (:action mop
    :parameters (?x - room)
    :precondition (and (at ?x) (not (clean ?x)))
    :effect (oneof (and) (clean ?x)))
  ; Nobody knows what the cupboard contains.
  (:action look
    :parameters (?x - room)
    :precondition (and (at ?x) (cupboard ?x) (closed))
    :effect (and (not (closed)) (oneof (has tin) (has ball))))
  (:action feed
    :precondition (has tin)
    :effect (and (not (has tin)) (fed)))
  (:action play
    :precondition (has ball)
    :effect (played)))
