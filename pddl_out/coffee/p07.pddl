; evaluation task 6 of seed 0, environment coffee
(define (problem p07)
  (:domain coffee)
  (:objects
    cup0 cup1 - cup
    plate-object - plate
    pot-object - pot
    robby - gripper)
  (:init
    (handempty robby)
    (notabovecup robby pot-object)
    (ontable pot-object))
  (:goal (and
    (cupfilled cup0)
    (cupfilled cup1))))
