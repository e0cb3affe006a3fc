; Skills of environment coffee, learned by bpns 0.1.0 from 1000 demonstrations
; (demonstrations of seed 0, learning with seed 0). You may edit this file: keep the
; operators' names and the types of their parameters.
(define (domain coffee)
  (:requirements :strips :typing)
  (:types
    gripper pot plate cup - object)
  (:predicates
    (cupfilled ?x0 - cup)
    (holding ?x0 - gripper ?x1 - pot)
    (potonplate ?x0 - pot ?x1 - plate)
    (buttonpressed ?x0 - plate)
    (ontable ?x0 - pot)
    (twisting ?x0 - gripper ?x1 - pot)
    (handempty ?x0 - gripper)
    (pothot ?x0 - pot)
    (robotabovecup ?x0 - gripper ?x1 - cup)
    (potabovecup ?x0 - pot ?x1 - cup)
    (notabovecup ?x0 - gripper ?x1 - pot)
    (pressingbutton ?x0 - gripper ?x1 - plate))

  ; learned from 485 demonstrations, 485 segments
  (:action op0
    :parameters (?x0 - pot ?x1 - gripper)
    :precondition (and
      (handempty ?x1)
      (notabovecup ?x1 ?x0)
      (ontable ?x0))
    :effect (and
      (twisting ?x1 ?x0)
      (not (handempty ?x1))))

  ; learned from 485 demonstrations, 485 segments
  (:action op1
    :parameters (?x0 - pot ?x1 - gripper)
    :precondition (and
      (notabovecup ?x1 ?x0)
      (ontable ?x0)
      (twisting ?x1 ?x0))
    :effect (and
      (handempty ?x1)
      (not (twisting ?x1 ?x0))))

  ; learned from 1000 demonstrations, 1000 segments
  (:action op2
    :parameters (?x0 - pot ?x1 - gripper)
    :precondition (and
      (handempty ?x1)
      (notabovecup ?x1 ?x0)
      (ontable ?x0))
    :effect (and
      (holding ?x1 ?x0)
      (not (handempty ?x1))
      (not (ontable ?x0))))

  ; learned from 1000 demonstrations, 1000 segments
  (:action op3
    :parameters (?x0 - plate ?x1 - pot ?x2 - gripper)
    :precondition (and
      (holding ?x2 ?x1)
      (notabovecup ?x2 ?x1))
    :effect (and
      (handempty ?x2)
      (potonplate ?x1 ?x0)
      (not (holding ?x2 ?x1))))

  ; learned from 1000 demonstrations, 1000 segments
  (:action op4
    :parameters (?x0 - plate ?x1 - pot ?x2 - gripper)
    :precondition (and
      (handempty ?x2)
      (notabovecup ?x2 ?x1)
      (potonplate ?x1 ?x0))
    :effect (and
      (buttonpressed ?x0)
      (pothot ?x1)
      (pressingbutton ?x2 ?x0)))

  ; learned from 1000 demonstrations, 1000 segments
  (:action op5
    :parameters (?x0 - plate ?x1 - pot ?x2 - gripper)
    :precondition (and
      (buttonpressed ?x0)
      (handempty ?x2)
      (notabovecup ?x2 ?x1)
      (pothot ?x1)
      (potonplate ?x1 ?x0)
      (pressingbutton ?x2 ?x0))
    :effect (and
      (holding ?x2 ?x1)
      (not (handempty ?x2))
      (not (potonplate ?x1 ?x0))
      (not (pressingbutton ?x2 ?x0))))

  ; learned from 1000 demonstrations, 1000 segments
  (:action op6
    :parameters (?x0 - cup ?x1 - pot ?x2 - gripper)
    :precondition (and
      (holding ?x2 ?x1)
      (notabovecup ?x2 ?x1)
      (pothot ?x1))
    :effect (and
      (cupfilled ?x0)
      (potabovecup ?x1 ?x0)
      (robotabovecup ?x2 ?x0)
      (not (notabovecup ?x2 ?x1))))

  ; learned from 470 demonstrations, 470 segments
  (:action op7
    :parameters (?x0 - cup ?x1 - cup ?x2 - pot ?x3 - gripper)
    :precondition (and
      (cupfilled ?x1)
      (holding ?x3 ?x2)
      (potabovecup ?x2 ?x1)
      (pothot ?x2)
      (robotabovecup ?x3 ?x1))
    :effect (and
      (cupfilled ?x0)
      (potabovecup ?x2 ?x0)
      (robotabovecup ?x3 ?x0)
      (not (potabovecup ?x2 ?x1))
      (not (robotabovecup ?x3 ?x1)))))
