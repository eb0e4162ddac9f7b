# The types of view.py when it is compiled.
cimport cython
from colonysim.pheromones.marks cimport Marks
from colonysim.policies.sensing cimport Senses
from colonysim.world.visibility cimport Visibility
from colonysim.world.state cimport World
from colonysim.world.terrain cimport Terrain

cdef class LocalView


@cython.final
cdef class FieldWindow:
    cdef LocalView _view
    cdef public object _field
    cdef Marks _marks
    cdef Senses _senses
    cdef bint _by_box, _gathers
    cdef unsigned long long _tag

    cpdef double at(self, int node, int key=*) except? -1
    cpdef _misread(self, Senses senses)
    @cython.locals(node=int)
    cpdef list values(self, nodes)
    cpdef keys(self, int node)
    @cython.locals(value=double)
    cpdef double read(self, int node, int key=*) except? -1
    cpdef int gather(self, int node, int[::1] found, int count, unsigned char[::1] marked) except -1
    cdef int _check(self, int node) except -1


@cython.final
cdef class LocalView:
    cdef public World _world
    cdef public object _backend, _feasible_way, refused, outcome
    cdef public int agent, node, goal, held_box, failures
    cdef public long long steps
    cdef public double radius, edge_seconds, waited
    cdef object _fields
    cdef dict _windows
    cdef public bint foresees, pushes_boxes
    cdef public FieldWindow d, b, h, e
    cdef unsigned long long _seen_as
    cdef int _overlooked
    cdef Senses _senses
    cdef bytearray _missed

    @cython.locals(world=World)
    cpdef look(self)
    cpdef _sense_with(self, Senses senses)
    @cython.locals(box=int, missed=bytearray)
    cdef _look_badly(self, Senses senses)
    cdef bint _misses(self, int box) except? -1
    cdef bint _misplaces(self) except? -1
    cdef double _apart(self, int i, int j) except? -1
    @cython.locals(visibility=Visibility, terrain=Terrain, look="long long", k=int, edge=int)
    cdef Visibility _misjudge(self, Senses senses)
    @cython.locals(visibility=Visibility, terrain=Terrain, edge=int, j=int, dx=double, dy=double)
    cdef _measure(self, Senses senses, int node, long long look)
    @cython.locals(visibility=Visibility)
    cdef (int, int) _find_box_badly(self, double level, int shunned, int barred, others, bint past) except *
    cpdef bint beside(self, int node) except? -1
    cpdef bint sees(self, int node)
    cdef int _look_at(self, int node) except -1
    cpdef (double, double) position(self, int node) except *
    cpdef bint beside_box(self, int node) except? -1
    @cython.locals(visibility=Visibility)
    cpdef tuple around(self)
    cpdef bint passable(self, int neighbour) except? -1
    cpdef bint occupied(self, int node) except? -1
    @cython.locals(world=World, terrain=Terrain, edge=int, k=int)
    cpdef bint crowded(self, int neighbour) except? -1
    @cython.locals(found="int[::1]", k=int)
    cpdef list exits(self)
    cpdef int exits_into(self, int[::1] found) except -1
    cpdef bint free(self, int node) except? -1
    cpdef bint wanted(self, int node) except? -1
    cpdef bint requested(self) except? -1
    cpdef list boxes(self)
    @cython.locals(node=int)
    cpdef int box_node(self, int box) except? -1
    cpdef bint box_at_hand(self) except? -1
    @cython.locals(world=World)
    cpdef bint box_in_sight(self) except? -1
    @cython.locals(box=int)
    cpdef int top_box(self, int node) except? -2
    @cython.locals(world=World, terrain=Terrain, count=int, edge=int, j=int)
    cpdef int boxes_beside(self, int[::1] found) except -1
    cpdef double box_height(self, int box) except? -1
    cpdef bint on_top(self, int box) except? -1
    @cython.locals(level=double, world=World)
    cpdef bint graspable_from(self, int node, int box) except? -1
    cpdef tuple holes(self)
    cpdef bint hole_in_sight(self) except? -1
    @cython.locals(world=World, visibility=Visibility, reach=double, near=int, k=int, hole=int)
    cpdef bint open_hole_in_sight(self) except? -1
    @cython.locals(visibility=Visibility, count=int, near=int, k=int, hole=int)
    cpdef int holes_into(self, int[::1] found, int centre) except -1
    cpdef int hole_node(self, int hole) except? -1
    @cython.locals(world=World)
    cpdef bint sees_hole(self, int hole) except -1
    cpdef bint hole_near(self, int hole, int node) except? -1
    cpdef double headroom(self, int hole) except? -1
    cdef int _hole(self, int hole) except -1
    @cython.locals(world=World)
    cpdef bint can_slide(self, int box, int i, int j) except? -1
    @cython.locals(world=World)
    cpdef bint can_follow(self, int box, int i, int j) except? -1
    cpdef list pushes(self, int box, int barred=*)
    cpdef int pushes_into(self, int box, int barred, int[::1] found) except -1
    @cython.locals(world=World, level=double, visibility=Visibility, missed=bytearray)
    cpdef (int, int) find_box(self, int shunned, int barred, others=*, bint past=*) except *
    cpdef feasible(self, int box, targets)
    cpdef nearest_box(self, shunned=*, int barred=*)
    cpdef tuple way_to_hole(self, int box, int hole, int barred=*, avoided=*)
