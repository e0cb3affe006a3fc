; evaluation task 4 of seed 0, environment doors
(define (problem p05)
  (:domain doors)
  (:objects
    bottom-door-0-0 bottom-door-0-1 bottom-door-0-2 bottom-door-0-3 bottom-door-1-0 bottom-door-1-1 bottom-door-1-2 bottom-door-1-3 bottom-door-2-1 left-door-0-1 left-door-0-2 left-door-0-3 left-door-1-1 left-door-1-2 left-door-1-3 left-door-1-4 left-door-2-1 left-door-2-2 left-door-2-3 - door
    robby - robot
    room-0-0 - room
    room-0-0-obstacle-0 room-0-0-obstacle-1 room-0-0-obstacle-2 - obstacle
    room-0-1 room-0-2 - room
    room-0-2-obstacle-0 room-0-2-obstacle-1 room-0-2-obstacle-2 - obstacle
    room-0-3 - room
    room-0-3-obstacle-0 room-0-3-obstacle-1 room-0-3-obstacle-2 - obstacle
    room-1-0 - room
    room-1-0-obstacle-0 room-1-0-obstacle-1 - obstacle
    room-1-1 - room
    room-1-1-obstacle-0 room-1-1-obstacle-1 room-1-1-obstacle-2 - obstacle
    room-1-2 - room
    room-1-2-obstacle-0 - obstacle
    room-1-3 - room
    room-1-3-obstacle-0 room-1-3-obstacle-1 room-1-3-obstacle-2 - obstacle
    room-1-4 - room
    room-1-4-obstacle-0 room-1-4-obstacle-1 - obstacle
    room-2-0 - room
    room-2-0-obstacle-0 - obstacle
    room-2-1 - room
    room-2-1-obstacle-0 room-2-1-obstacle-1 - obstacle
    room-2-2 - room
    room-2-2-obstacle-0 - obstacle
    room-2-3 - room
    room-2-3-obstacle-0 room-2-3-obstacle-1 room-2-3-obstacle-2 - obstacle
    room-3-1 - room
    room-3-1-obstacle-0 wall-0-0-0 wall-0-0-1 wall-0-0-2 wall-0-0-3 wall-0-0-4 wall-0-0-5 wall-0-1-0 wall-0-1-1 wall-0-1-2 wall-0-1-3 wall-0-1-4 wall-0-1-5 wall-0-1-6 wall-0-2-0 wall-0-2-1 wall-0-2-2 wall-0-2-3 wall-0-2-4 wall-0-2-5 wall-0-2-6 wall-0-3-0 wall-0-3-1 wall-0-3-2 wall-0-3-3 wall-0-3-4 wall-0-3-5 wall-1-0-0 wall-1-0-1 wall-1-0-2 wall-1-0-3 wall-1-0-4 wall-1-0-5 wall-1-0-6 wall-1-1-0 wall-1-1-1 wall-1-1-2 wall-1-1-3 wall-1-1-4 wall-1-1-5 wall-1-1-6 wall-1-1-7 wall-1-2-0 wall-1-2-1 wall-1-2-2 wall-1-2-3 wall-1-2-4 wall-1-2-5 wall-1-2-6 wall-1-2-7 wall-1-3-0 wall-1-3-1 wall-1-3-2 wall-1-3-3 wall-1-3-4 wall-1-3-5 wall-1-3-6 wall-1-3-7 wall-1-4-0 wall-1-4-1 wall-1-4-2 wall-1-4-3 wall-1-4-4 wall-2-0-0 wall-2-0-1 wall-2-0-2 wall-2-0-3 wall-2-0-4 wall-2-0-5 wall-2-1-0 wall-2-1-1 wall-2-1-2 wall-2-1-3 wall-2-1-4 wall-2-1-5 wall-2-1-6 wall-2-1-7 wall-2-2-0 wall-2-2-1 wall-2-2-2 wall-2-2-3 wall-2-2-4 wall-2-2-5 wall-2-2-6 wall-2-3-0 wall-2-3-1 wall-2-3-2 wall-2-3-3 wall-2-3-4 wall-2-3-5 wall-3-1-0 wall-3-1-1 wall-3-1-2 wall-3-1-3 wall-3-1-4 - obstacle)
  (:init
    (doorinroom bottom-door-0-0 room-0-0)
    (doorinroom bottom-door-0-0 room-1-0)
    (doorinroom bottom-door-0-1 room-0-1)
    (doorinroom bottom-door-0-1 room-1-1)
    (doorinroom bottom-door-0-2 room-0-2)
    (doorinroom bottom-door-0-2 room-1-2)
    (doorinroom bottom-door-0-3 room-0-3)
    (doorinroom bottom-door-0-3 room-1-3)
    (doorinroom bottom-door-1-0 room-1-0)
    (doorinroom bottom-door-1-0 room-2-0)
    (doorinroom bottom-door-1-1 room-1-1)
    (doorinroom bottom-door-1-1 room-2-1)
    (doorinroom bottom-door-1-2 room-1-2)
    (doorinroom bottom-door-1-2 room-2-2)
    (doorinroom bottom-door-1-3 room-1-3)
    (doorinroom bottom-door-1-3 room-2-3)
    (doorinroom bottom-door-2-1 room-2-1)
    (doorinroom bottom-door-2-1 room-3-1)
    (doorinroom left-door-0-1 room-0-0)
    (doorinroom left-door-0-1 room-0-1)
    (doorinroom left-door-0-2 room-0-1)
    (doorinroom left-door-0-2 room-0-2)
    (doorinroom left-door-0-3 room-0-2)
    (doorinroom left-door-0-3 room-0-3)
    (doorinroom left-door-1-1 room-1-0)
    (doorinroom left-door-1-1 room-1-1)
    (doorinroom left-door-1-2 room-1-1)
    (doorinroom left-door-1-2 room-1-2)
    (doorinroom left-door-1-3 room-1-2)
    (doorinroom left-door-1-3 room-1-3)
    (doorinroom left-door-1-4 room-1-3)
    (doorinroom left-door-1-4 room-1-4)
    (doorinroom left-door-2-1 room-2-0)
    (doorinroom left-door-2-1 room-2-1)
    (doorinroom left-door-2-2 room-2-1)
    (doorinroom left-door-2-2 room-2-2)
    (doorinroom left-door-2-3 room-2-2)
    (doorinroom left-door-2-3 room-2-3)
    (doorsshareroom bottom-door-0-0 bottom-door-1-0)
    (doorsshareroom bottom-door-0-0 left-door-0-1)
    (doorsshareroom bottom-door-0-0 left-door-1-1)
    (doorsshareroom bottom-door-0-1 bottom-door-1-1)
    (doorsshareroom bottom-door-0-1 left-door-0-1)
    (doorsshareroom bottom-door-0-1 left-door-0-2)
    (doorsshareroom bottom-door-0-1 left-door-1-1)
    (doorsshareroom bottom-door-0-1 left-door-1-2)
    (doorsshareroom bottom-door-0-2 bottom-door-1-2)
    (doorsshareroom bottom-door-0-2 left-door-0-2)
    (doorsshareroom bottom-door-0-2 left-door-0-3)
    (doorsshareroom bottom-door-0-2 left-door-1-2)
    (doorsshareroom bottom-door-0-2 left-door-1-3)
    (doorsshareroom bottom-door-0-3 bottom-door-1-3)
    (doorsshareroom bottom-door-0-3 left-door-0-3)
    (doorsshareroom bottom-door-0-3 left-door-1-3)
    (doorsshareroom bottom-door-0-3 left-door-1-4)
    (doorsshareroom bottom-door-1-0 bottom-door-0-0)
    (doorsshareroom bottom-door-1-0 left-door-1-1)
    (doorsshareroom bottom-door-1-0 left-door-2-1)
    (doorsshareroom bottom-door-1-1 bottom-door-0-1)
    (doorsshareroom bottom-door-1-1 bottom-door-2-1)
    (doorsshareroom bottom-door-1-1 left-door-1-1)
    (doorsshareroom bottom-door-1-1 left-door-1-2)
    (doorsshareroom bottom-door-1-1 left-door-2-1)
    (doorsshareroom bottom-door-1-1 left-door-2-2)
    (doorsshareroom bottom-door-1-2 bottom-door-0-2)
    (doorsshareroom bottom-door-1-2 left-door-1-2)
    (doorsshareroom bottom-door-1-2 left-door-1-3)
    (doorsshareroom bottom-door-1-2 left-door-2-2)
    (doorsshareroom bottom-door-1-2 left-door-2-3)
    (doorsshareroom bottom-door-1-3 bottom-door-0-3)
    (doorsshareroom bottom-door-1-3 left-door-1-3)
    (doorsshareroom bottom-door-1-3 left-door-1-4)
    (doorsshareroom bottom-door-1-3 left-door-2-3)
    (doorsshareroom bottom-door-2-1 bottom-door-1-1)
    (doorsshareroom bottom-door-2-1 left-door-2-1)
    (doorsshareroom bottom-door-2-1 left-door-2-2)
    (doorsshareroom left-door-0-1 bottom-door-0-0)
    (doorsshareroom left-door-0-1 bottom-door-0-1)
    (doorsshareroom left-door-0-1 left-door-0-2)
    (doorsshareroom left-door-0-2 bottom-door-0-1)
    (doorsshareroom left-door-0-2 bottom-door-0-2)
    (doorsshareroom left-door-0-2 left-door-0-1)
    (doorsshareroom left-door-0-2 left-door-0-3)
    (doorsshareroom left-door-0-3 bottom-door-0-2)
    (doorsshareroom left-door-0-3 bottom-door-0-3)
    (doorsshareroom left-door-0-3 left-door-0-2)
    (doorsshareroom left-door-1-1 bottom-door-0-0)
    (doorsshareroom left-door-1-1 bottom-door-0-1)
    (doorsshareroom left-door-1-1 bottom-door-1-0)
    (doorsshareroom left-door-1-1 bottom-door-1-1)
    (doorsshareroom left-door-1-1 left-door-1-2)
    (doorsshareroom left-door-1-2 bottom-door-0-1)
    (doorsshareroom left-door-1-2 bottom-door-0-2)
    (doorsshareroom left-door-1-2 bottom-door-1-1)
    (doorsshareroom left-door-1-2 bottom-door-1-2)
    (doorsshareroom left-door-1-2 left-door-1-1)
    (doorsshareroom left-door-1-2 left-door-1-3)
    (doorsshareroom left-door-1-3 bottom-door-0-2)
    (doorsshareroom left-door-1-3 bottom-door-0-3)
    (doorsshareroom left-door-1-3 bottom-door-1-2)
    (doorsshareroom left-door-1-3 bottom-door-1-3)
    (doorsshareroom left-door-1-3 left-door-1-2)
    (doorsshareroom left-door-1-3 left-door-1-4)
    (doorsshareroom left-door-1-4 bottom-door-0-3)
    (doorsshareroom left-door-1-4 bottom-door-1-3)
    (doorsshareroom left-door-1-4 left-door-1-3)
    (doorsshareroom left-door-2-1 bottom-door-1-0)
    (doorsshareroom left-door-2-1 bottom-door-1-1)
    (doorsshareroom left-door-2-1 bottom-door-2-1)
    (doorsshareroom left-door-2-1 left-door-2-2)
    (doorsshareroom left-door-2-2 bottom-door-1-1)
    (doorsshareroom left-door-2-2 bottom-door-1-2)
    (doorsshareroom left-door-2-2 bottom-door-2-1)
    (doorsshareroom left-door-2-2 left-door-2-1)
    (doorsshareroom left-door-2-2 left-door-2-3)
    (doorsshareroom left-door-2-3 bottom-door-1-2)
    (doorsshareroom left-door-2-3 bottom-door-1-3)
    (doorsshareroom left-door-2-3 left-door-2-2)
    (inmainroom robby room-3-1)
    (inroom robby room-3-1))
  (:goal (and
    (inroom robby room-1-0))))
