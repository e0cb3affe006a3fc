; evaluation task 4 of seed 0, environment cover
(define (problem p05)
  (:domain cover)
  (:objects
    block0 - block
    block0-region - block-region
    block1 - block
    block1-region - block-region
    robby - gripper
    target0 - target
    target0-region - target-region
    target1 - target
    target1-region - target-region)
  (:init
    (handempty)
    (isblock block0)
    (isblock block1)
    (istarget target0)
    (istarget target1))
  (:goal (and
    (covers block1 target1))))
