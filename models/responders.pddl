; First responders: a fire engine, victims on both sides of a river, and a bridge that may not last.
; Both parts of the problem stand in this file.
(define (domain responders)
  (:requirements :typing :negative-preconditions :non-deterministic)
  (:types place)
  (:predicates (at ?x - place) (road ?x ?y - place) (bridge ?x ?y - place) (burning ?x - place)
    (victim ?x - place) (saved ?x - place))
  (:action drive
    :parameters (?x ?y - place)
    :precondition (and (at ?x) (road ?x ?y))
    :effect (and (not (at ?x)) (at ?y)))
  (:action cross
    :parameters (?x ?y - place)
    :precondition (and (at ?x) (bridge ?x ?y))
    :effect (and (not (at ?x)) (at ?y)
      (oneof (and) (and (not (bridge ?x ?y)) (not (bridge ?y ?x))))))
  (:action extinguish
    :parameters (?x - place)
    :precondition (and (at ?x) (burning ?x))
    :effect (oneof (and) (not (burning ?x))))
  (:action rescue
    :parameters (?x - place)
    :precondition (and (at ?x) (victim ?x) (not (burning ?x)))
    :effect (and (not (victim ?x)) (saved ?x))))

(define (problem river)
  (:domain responders)
  (:objects station mill school farm - place)
  (:init (at station)
    (road station school) (road school station) (bridge station mill) (bridge mill station)
    (road mill farm) (road farm mill)
    (victim school) (victim farm) (burning school) (burning farm))
  (:goal (and (saved school) (saved farm))))
