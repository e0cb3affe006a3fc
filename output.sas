begin_version
3
end_version
begin_metric
0
end_metric
2
begin_variable
var0
-1
2
Atom hand-empty(r1)
Atom holding(r1, c1)
end_variable
begin_variable
var1
-1
2
Atom filled(c1)
NegatedAtom filled(c1)
end_variable
1
begin_mutex_group
fw
2
0 0
1 0
end_mutex_group
begin_state
0
1
end_state
begin_goal
1
1 0
end_goal
2
begin_operator
fill r1 c1
1
0 1
1
0 1 -1 0
1
end_operator
begin_operator
pick r1 c1
0
1
0 0 0 1
1
end_operator
0
