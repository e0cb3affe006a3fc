; evaluation task 0 of seed 0, environment doors
(define (problem p01)
  (:domain doors)
  (:objects
    bottom-door-1-2 bottom-door-2-1 bottom-door-2-2 bottom-door-2-3 bottom-door-3-2 left-door-2-2 left-door-2-3 left-door-3-2 left-door-3-3 - door
    robby - robot
    room-1-2 - room
    room-1-2-obstacle-0 - obstacle
    room-2-1 room-2-2 room-2-3 - room
    room-2-3-obstacle-0 room-2-3-obstacle-1 - obstacle
    room-3-1 - room
    room-3-1-obstacle-0 room-3-1-obstacle-1 room-3-1-obstacle-2 - obstacle
    room-3-2 - room
    room-3-2-obstacle-0 - obstacle
    room-3-3 - room
    room-3-3-obstacle-0 room-3-3-obstacle-1 room-3-3-obstacle-2 - obstacle
    room-4-2 - room
    wall-1-2-0 wall-1-2-1 wall-1-2-2 wall-1-2-3 wall-1-2-4 wall-2-1-0 wall-2-1-1 wall-2-1-2 wall-2-1-3 wall-2-1-4 wall-2-1-5 wall-2-2-0 wall-2-2-1 wall-2-2-2 wall-2-2-3 wall-2-2-4 wall-2-2-5 wall-2-2-6 wall-2-2-7 wall-2-3-0 wall-2-3-1 wall-2-3-2 wall-2-3-3 wall-2-3-4 wall-2-3-5 wall-3-1-0 wall-3-1-1 wall-3-1-2 wall-3-1-3 wall-3-1-4 wall-3-1-5 wall-3-2-0 wall-3-2-1 wall-3-2-2 wall-3-2-3 wall-3-2-4 wall-3-2-5 wall-3-2-6 wall-3-2-7 wall-3-3-0 wall-3-3-1 wall-3-3-2 wall-3-3-3 wall-3-3-4 wall-3-3-5 wall-4-2-0 wall-4-2-1 wall-4-2-2 wall-4-2-3 wall-4-2-4 - obstacle)
  (:init
    (doorinroom bottom-door-1-2 room-1-2)
    (doorinroom bottom-door-1-2 room-2-2)
    (doorinroom bottom-door-2-1 room-2-1)
    (doorinroom bottom-door-2-1 room-3-1)
    (doorinroom bottom-door-2-2 room-2-2)
    (doorinroom bottom-door-2-2 room-3-2)
    (doorinroom bottom-door-2-3 room-2-3)
    (doorinroom bottom-door-2-3 room-3-3)
    (doorinroom bottom-door-3-2 room-3-2)
    (doorinroom bottom-door-3-2 room-4-2)
    (doorinroom left-door-2-2 room-2-1)
    (doorinroom left-door-2-2 room-2-2)
    (doorinroom left-door-2-3 room-2-2)
    (doorinroom left-door-2-3 room-2-3)
    (doorinroom left-door-3-2 room-3-1)
    (doorinroom left-door-3-2 room-3-2)
    (doorinroom left-door-3-3 room-3-2)
    (doorinroom left-door-3-3 room-3-3)
    (doorsshareroom bottom-door-1-2 bottom-door-2-2)
    (doorsshareroom bottom-door-1-2 left-door-2-2)
    (doorsshareroom bottom-door-1-2 left-door-2-3)
    (doorsshareroom bottom-door-2-1 left-door-2-2)
    (doorsshareroom bottom-door-2-1 left-door-3-2)
    (doorsshareroom bottom-door-2-2 bottom-door-1-2)
    (doorsshareroom bottom-door-2-2 bottom-door-3-2)
    (doorsshareroom bottom-door-2-2 left-door-2-2)
    (doorsshareroom bottom-door-2-2 left-door-2-3)
    (doorsshareroom bottom-door-2-2 left-door-3-2)
    (doorsshareroom bottom-door-2-2 left-door-3-3)
    (doorsshareroom bottom-door-2-3 left-door-2-3)
    (doorsshareroom bottom-door-2-3 left-door-3-3)
    (doorsshareroom bottom-door-3-2 bottom-door-2-2)
    (doorsshareroom bottom-door-3-2 left-door-3-2)
    (doorsshareroom bottom-door-3-2 left-door-3-3)
    (doorsshareroom left-door-2-2 bottom-door-1-2)
    (doorsshareroom left-door-2-2 bottom-door-2-1)
    (doorsshareroom left-door-2-2 bottom-door-2-2)
    (doorsshareroom left-door-2-2 left-door-2-3)
    (doorsshareroom left-door-2-3 bottom-door-1-2)
    (doorsshareroom left-door-2-3 bottom-door-2-2)
    (doorsshareroom left-door-2-3 bottom-door-2-3)
    (doorsshareroom left-door-2-3 left-door-2-2)
    (doorsshareroom left-door-3-2 bottom-door-2-1)
    (doorsshareroom left-door-3-2 bottom-door-2-2)
    (doorsshareroom left-door-3-2 bottom-door-3-2)
    (doorsshareroom left-door-3-2 left-door-3-3)
    (doorsshareroom left-door-3-3 bottom-door-2-2)
    (doorsshareroom left-door-3-3 bottom-door-2-3)
    (doorsshareroom left-door-3-3 bottom-door-3-2)
    (doorsshareroom left-door-3-3 left-door-3-2)
    (inmainroom robby room-2-2)
    (inroom robby room-2-2))
  (:goal (and
    (inroom robby room-3-2))))
