; evaluation task 2 of seed 0, environment stick_button
(define (problem p03)
  (:domain stick_button)
  (:objects
    button0 button1 button2 - button
    holder-object - holder
    robby - gripper
    stick-object - stick)
  (:init
    (abovenobutton)
    (handempty robby))
  (:goal (and
    (pressed button0)
    (pressed button1)
    (pressed button2))))
