; Skills of environment stick_button, learned by bpns 0.1.0 from 959 demonstrations
; (demonstrations of seed 0, learning with seed 0). You may edit this file: keep the
; operators' names and the types of their parameters.
(define (domain stick_button)
  (:requirements :strips :typing)
  (:types
    gripper button stick holder - object)
  (:predicates
    (abovenobutton)
    (grasped ?x0 - gripper ?x1 - stick)
    (handempty ?x0 - gripper)
    (pressed ?x0 - button)
    (robotabovebutton ?x0 - gripper ?x1 - button)
    (stickabovebutton ?x0 - stick ?x1 - button))

  ; learned from 544 demonstrations, 544 segments
  (:action op0
    :parameters (?x0 - button ?x1 - gripper)
    :precondition (and
      (abovenobutton)
      (handempty ?x1))
    :effect (and
      (pressed ?x0)
      (robotabovebutton ?x1 ?x0)
      (not (abovenobutton))))

  ; learned from 191 demonstrations, 191 segments
  (:action op1
    :parameters (?x0 - button ?x1 - gripper ?x2 - stick)
    :precondition (and
      (handempty ?x1)
      (pressed ?x0)
      (robotabovebutton ?x1 ?x0))
    :effect (and
      (abovenobutton)
      (grasped ?x1 ?x2)
      (not (handempty ?x1))
      (not (robotabovebutton ?x1 ?x0))))

  ; learned from 603 demonstrations, 603 segments
  (:action op2
    :parameters (?x0 - button ?x1 - stick ?x2 - gripper)
    :precondition (and
      (abovenobutton)
      (grasped ?x2 ?x1))
    :effect (and
      (pressed ?x0)
      (stickabovebutton ?x1 ?x0)
      (not (abovenobutton))))

  ; learned from 415 demonstrations, 415 segments
  (:action op3
    :parameters (?x0 - gripper ?x1 - stick)
    :precondition (and
      (abovenobutton)
      (handempty ?x0))
    :effect (and
      (grasped ?x0 ?x1)
      (not (handempty ?x0))))

  ; learned from 163 demonstrations, 163 segments
  (:action op4
    :parameters (?x0 - button ?x1 - button ?x2 - stick ?x3 - gripper)
    :precondition (and
      (grasped ?x3 ?x2)
      (pressed ?x0)
      (stickabovebutton ?x2 ?x0))
    :effect (and
      (pressed ?x1)
      (stickabovebutton ?x2 ?x1)
      (not (stickabovebutton ?x2 ?x0))))

  ; learned from 116 demonstrations, 116 segments
  (:action op5
    :parameters (?x0 - button ?x1 - button ?x2 - gripper)
    :precondition (and
      (handempty ?x2)
      (pressed ?x1)
      (robotabovebutton ?x2 ?x1))
    :effect (and
      (pressed ?x0)
      (robotabovebutton ?x2 ?x0)
      (not (robotabovebutton ?x2 ?x1)))))
