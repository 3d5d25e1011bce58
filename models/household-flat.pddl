; A flat with three rooms. What the robot achieves has preferences, whose order stands in household.pref.
(define (problem flat)
  (:domain household)
  (:requirements :preferences)
  (:objects hall kitchen bath - room)
  (:init (at hall) (door hall kitchen) (door kitchen hall) (door hall bath) (door bath hall)
    (cupboard kitchen) (closed))
  (:goal (and
    (preference clean (clean hall))
    (preference fed (fed))
    (preference played (played)))))
