; Skills of environment doors, learned by bpns 0.1.0 from 1000 demonstrations
; (demonstrations of seed 0, learning with seed 0). You may edit this file: keep the
; operators' names and the types of their parameters.
(define (domain doors)
  (:requirements :strips :typing)
  (:types
    robot door room obstacle - object)
  (:predicates
    (doorinroom ?x0 - door ?x1 - room)
    (doorisopen ?x0 - door)
    (doorsshareroom ?x0 - door ?x1 - door)
    (indoorway ?x0 - robot ?x1 - door)
    (inmainroom ?x0 - robot ?x1 - room)
    (inroom ?x0 - robot ?x1 - room)
    (touchingdoor ?x0 - robot ?x1 - door))

  ; learned from 1000 demonstrations, 1000 segments
  (:action op0
    :parameters (?x0 - door ?x1 - robot ?x2 - room)
    :precondition (and
      (doorinroom ?x0 ?x2)
      (inmainroom ?x1 ?x2)
      (inroom ?x1 ?x2))
    :effect (and
      (indoorway ?x1 ?x0)
      (touchingdoor ?x1 ?x0)
      (not (inmainroom ?x1 ?x2))))

  ; learned from 1000 demonstrations, 2449 segments
  (:action op1
    :parameters (?x0 - door ?x1 - robot ?x2 - room)
    :precondition (and
      (doorinroom ?x0 ?x2)
      (indoorway ?x1 ?x0)
      (inroom ?x1 ?x2)
      (touchingdoor ?x1 ?x0))
    :effect (and
      (doorisopen ?x0)
      (not (touchingdoor ?x1 ?x0))))

  ; learned from 1000 demonstrations, 2449 segments
  (:action op2
    :parameters (?x0 - door ?x1 - robot ?x2 - room ?x3 - room)
    :precondition (and
      (doorinroom ?x0 ?x2)
      (doorinroom ?x0 ?x3)
      (doorisopen ?x0)
      (indoorway ?x1 ?x0)
      (inroom ?x1 ?x3))
    :effect (and
      (inroom ?x1 ?x2)
      (not (inroom ?x1 ?x3))))

  ; learned from 741 demonstrations, 1449 segments
  (:action op3
    :parameters (?x0 - door ?x1 - door ?x2 - robot ?x3 - room)
    :precondition (and
      (doorinroom ?x0 ?x3)
      (doorinroom ?x1 ?x3)
      (doorisopen ?x1)
      (doorsshareroom ?x0 ?x1)
      (doorsshareroom ?x1 ?x0)
      (indoorway ?x2 ?x1)
      (inroom ?x2 ?x3))
    :effect (and
      (indoorway ?x2 ?x0)
      (touchingdoor ?x2 ?x0)
      (not (indoorway ?x2 ?x1)))))
