; Skills of environment cover, learned by bpns 0.1.0 from 998 demonstrations
; (demonstrations of seed 0, learning with seed 0). You may edit this file: keep the
; operators' names and the types of their parameters.
(define (domain cover)
  (:requirements :strips :typing)
  (:types
    block target gripper allowed-region - object
    block-region target-region - allowed-region)
  (:predicates
    (covers ?x0 - block ?x1 - target)
    (handempty)
    (holding ?x0 - block ?x1 - gripper)
    (isblock ?x0 - block)
    (istarget ?x0 - target))

  ; learned from 998 demonstrations, 1357 segments
  (:action op0
    :parameters (?x0 - block ?x1 - gripper)
    :precondition (and
      (handempty)
      (isblock ?x0))
    :effect (and
      (holding ?x0 ?x1)
      (not (handempty))))

  ; learned from 998 demonstrations, 1357 segments
  (:action op1
    :parameters (?x0 - block ?x1 - gripper ?x2 - target)
    :precondition (and
      (holding ?x0 ?x1)
      (isblock ?x0)
      (istarget ?x2))
    :effect (and
      (covers ?x0 ?x2)
      (handempty)
      (not (holding ?x0 ?x1)))))
