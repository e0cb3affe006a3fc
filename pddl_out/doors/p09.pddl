; evaluation task 8 of seed 0, environment doors
(define (problem p09)
  (:domain doors)
  (:objects
    bottom-door-0-2 bottom-door-0-3 bottom-door-0-4 bottom-door-1-4 left-door-0-2 left-door-0-3 left-door-0-4 left-door-1-3 left-door-1-4 - door
    robby - robot
    room-0-1 - room
    room-0-1-obstacle-0 room-0-1-obstacle-1 - obstacle
    room-0-2 room-0-3 - room
    room-0-3-obstacle-0 - obstacle
    room-0-4 - room
    room-0-4-obstacle-0 room-0-4-obstacle-1 - obstacle
    room-1-2 room-1-3 - room
    room-1-3-obstacle-0 room-1-3-obstacle-1 room-1-3-obstacle-2 - obstacle
    room-1-4 - room
    room-1-4-obstacle-0 room-1-4-obstacle-1 - obstacle
    room-2-4 - room
    room-2-4-obstacle-0 room-2-4-obstacle-1 wall-0-1-0 wall-0-1-1 wall-0-1-2 wall-0-1-3 wall-0-1-4 wall-0-2-0 wall-0-2-1 wall-0-2-2 wall-0-2-3 wall-0-2-4 wall-0-2-5 wall-0-2-6 wall-0-3-0 wall-0-3-1 wall-0-3-2 wall-0-3-3 wall-0-3-4 wall-0-3-5 wall-0-3-6 wall-0-4-0 wall-0-4-1 wall-0-4-2 wall-0-4-3 wall-0-4-4 wall-0-4-5 wall-1-2-0 wall-1-2-1 wall-1-2-2 wall-1-2-3 wall-1-2-4 wall-1-2-5 wall-1-3-0 wall-1-3-1 wall-1-3-2 wall-1-3-3 wall-1-3-4 wall-1-3-5 wall-1-3-6 wall-1-4-0 wall-1-4-1 wall-1-4-2 wall-1-4-3 wall-1-4-4 wall-1-4-5 wall-1-4-6 wall-2-4-0 wall-2-4-1 wall-2-4-2 wall-2-4-3 wall-2-4-4 - obstacle)
  (:init
    (doorinroom bottom-door-0-2 room-0-2)
    (doorinroom bottom-door-0-2 room-1-2)
    (doorinroom bottom-door-0-3 room-0-3)
    (doorinroom bottom-door-0-3 room-1-3)
    (doorinroom bottom-door-0-4 room-0-4)
    (doorinroom bottom-door-0-4 room-1-4)
    (doorinroom bottom-door-1-4 room-1-4)
    (doorinroom bottom-door-1-4 room-2-4)
    (doorinroom left-door-0-2 room-0-1)
    (doorinroom left-door-0-2 room-0-2)
    (doorinroom left-door-0-3 room-0-2)
    (doorinroom left-door-0-3 room-0-3)
    (doorinroom left-door-0-4 room-0-3)
    (doorinroom left-door-0-4 room-0-4)
    (doorinroom left-door-1-3 room-1-2)
    (doorinroom left-door-1-3 room-1-3)
    (doorinroom left-door-1-4 room-1-3)
    (doorinroom left-door-1-4 room-1-4)
    (doorsshareroom bottom-door-0-2 left-door-0-2)
    (doorsshareroom bottom-door-0-2 left-door-0-3)
    (doorsshareroom bottom-door-0-2 left-door-1-3)
    (doorsshareroom bottom-door-0-3 left-door-0-3)
    (doorsshareroom bottom-door-0-3 left-door-0-4)
    (doorsshareroom bottom-door-0-3 left-door-1-3)
    (doorsshareroom bottom-door-0-3 left-door-1-4)
    (doorsshareroom bottom-door-0-4 bottom-door-1-4)
    (doorsshareroom bottom-door-0-4 left-door-0-4)
    (doorsshareroom bottom-door-0-4 left-door-1-4)
    (doorsshareroom bottom-door-1-4 bottom-door-0-4)
    (doorsshareroom bottom-door-1-4 left-door-1-4)
    (doorsshareroom left-door-0-2 bottom-door-0-2)
    (doorsshareroom left-door-0-2 left-door-0-3)
    (doorsshareroom left-door-0-3 bottom-door-0-2)
    (doorsshareroom left-door-0-3 bottom-door-0-3)
    (doorsshareroom left-door-0-3 left-door-0-2)
    (doorsshareroom left-door-0-3 left-door-0-4)
    (doorsshareroom left-door-0-4 bottom-door-0-3)
    (doorsshareroom left-door-0-4 bottom-door-0-4)
    (doorsshareroom left-door-0-4 left-door-0-3)
    (doorsshareroom left-door-1-3 bottom-door-0-2)
    (doorsshareroom left-door-1-3 bottom-door-0-3)
    (doorsshareroom left-door-1-3 left-door-1-4)
    (doorsshareroom left-door-1-4 bottom-door-0-3)
    (doorsshareroom left-door-1-4 bottom-door-0-4)
    (doorsshareroom left-door-1-4 bottom-door-1-4)
    (doorsshareroom left-door-1-4 left-door-1-3)
    (inmainroom robby room-1-2)
    (inroom robby room-1-2))
  (:goal (and
    (inroom robby room-0-2))))
