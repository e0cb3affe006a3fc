; evaluation task 7 of seed 0, environment doors
(define (problem p08)
  (:domain doors)
  (:objects
    bottom-door-1-0 bottom-door-2-0 bottom-door-2-1 bottom-door-3-0 bottom-door-3-1 left-door-2-1 left-door-3-1 left-door-4-1 left-door-4-2 - door
    robby - robot
    room-1-0 room-2-0 - room
    room-2-0-obstacle-0 room-2-0-obstacle-1 - obstacle
    room-2-1 - room
    room-2-1-obstacle-0 room-2-1-obstacle-1 - obstacle
    room-3-0 - room
    room-3-0-obstacle-0 room-3-0-obstacle-1 - obstacle
    room-3-1 - room
    room-3-1-obstacle-0 room-3-1-obstacle-1 room-3-1-obstacle-2 - obstacle
    room-4-0 room-4-1 - room
    room-4-1-obstacle-0 room-4-1-obstacle-1 - obstacle
    room-4-2 - room
    room-4-2-obstacle-0 room-4-2-obstacle-1 wall-1-0-0 wall-1-0-1 wall-1-0-2 wall-1-0-3 wall-1-0-4 wall-2-0-0 wall-2-0-1 wall-2-0-2 wall-2-0-3 wall-2-0-4 wall-2-0-5 wall-2-0-6 wall-2-1-0 wall-2-1-1 wall-2-1-2 wall-2-1-3 wall-2-1-4 wall-2-1-5 wall-3-0-0 wall-3-0-1 wall-3-0-2 wall-3-0-3 wall-3-0-4 wall-3-0-5 wall-3-0-6 wall-3-1-0 wall-3-1-1 wall-3-1-2 wall-3-1-3 wall-3-1-4 wall-3-1-5 wall-3-1-6 wall-4-0-0 wall-4-0-1 wall-4-0-2 wall-4-0-3 wall-4-0-4 wall-4-0-5 wall-4-1-0 wall-4-1-1 wall-4-1-2 wall-4-1-3 wall-4-1-4 wall-4-1-5 wall-4-1-6 wall-4-2-0 wall-4-2-1 wall-4-2-2 wall-4-2-3 wall-4-2-4 - obstacle)
  (:init
    (doorinroom bottom-door-1-0 room-1-0)
    (doorinroom bottom-door-1-0 room-2-0)
    (doorinroom bottom-door-2-0 room-2-0)
    (doorinroom bottom-door-2-0 room-3-0)
    (doorinroom bottom-door-2-1 room-2-1)
    (doorinroom bottom-door-2-1 room-3-1)
    (doorinroom bottom-door-3-0 room-3-0)
    (doorinroom bottom-door-3-0 room-4-0)
    (doorinroom bottom-door-3-1 room-3-1)
    (doorinroom bottom-door-3-1 room-4-1)
    (doorinroom left-door-2-1 room-2-0)
    (doorinroom left-door-2-1 room-2-1)
    (doorinroom left-door-3-1 room-3-0)
    (doorinroom left-door-3-1 room-3-1)
    (doorinroom left-door-4-1 room-4-0)
    (doorinroom left-door-4-1 room-4-1)
    (doorinroom left-door-4-2 room-4-1)
    (doorinroom left-door-4-2 room-4-2)
    (doorsshareroom bottom-door-1-0 bottom-door-2-0)
    (doorsshareroom bottom-door-1-0 left-door-2-1)
    (doorsshareroom bottom-door-2-0 bottom-door-1-0)
    (doorsshareroom bottom-door-2-0 bottom-door-3-0)
    (doorsshareroom bottom-door-2-0 left-door-2-1)
    (doorsshareroom bottom-door-2-0 left-door-3-1)
    (doorsshareroom bottom-door-2-1 bottom-door-3-1)
    (doorsshareroom bottom-door-2-1 left-door-2-1)
    (doorsshareroom bottom-door-2-1 left-door-3-1)
    (doorsshareroom bottom-door-3-0 bottom-door-2-0)
    (doorsshareroom bottom-door-3-0 left-door-3-1)
    (doorsshareroom bottom-door-3-0 left-door-4-1)
    (doorsshareroom bottom-door-3-1 bottom-door-2-1)
    (doorsshareroom bottom-door-3-1 left-door-3-1)
    (doorsshareroom bottom-door-3-1 left-door-4-1)
    (doorsshareroom bottom-door-3-1 left-door-4-2)
    (doorsshareroom left-door-2-1 bottom-door-1-0)
    (doorsshareroom left-door-2-1 bottom-door-2-0)
    (doorsshareroom left-door-2-1 bottom-door-2-1)
    (doorsshareroom left-door-3-1 bottom-door-2-0)
    (doorsshareroom left-door-3-1 bottom-door-2-1)
    (doorsshareroom left-door-3-1 bottom-door-3-0)
    (doorsshareroom left-door-3-1 bottom-door-3-1)
    (doorsshareroom left-door-4-1 bottom-door-3-0)
    (doorsshareroom left-door-4-1 bottom-door-3-1)
    (doorsshareroom left-door-4-1 left-door-4-2)
    (doorsshareroom left-door-4-2 bottom-door-3-1)
    (doorsshareroom left-door-4-2 left-door-4-1)
    (inmainroom robby room-4-2)
    (inroom robby room-4-2))
  (:goal (and
    (inroom robby room-3-0))))
