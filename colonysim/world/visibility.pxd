# The types of visibility.py when it is compiled.
cimport cython
from colonysim.world.neighbourhoods cimport Neighbourhoods
from colonysim.world.terrain cimport Terrain

cdef double DIAGONAL, SHORT


@cython.final
cdef class Visibility:
    cdef int size, centre, at, within, watch, waiting
    cdef Neighbourhoods neighbourhoods
    cdef long long look, search
    cdef double shortest, own_shortest, guide
    cdef double[::1] own_lengths
    cdef Terrain terrain
    cdef double[::1] lengths, rises, surface, box_base, far, stand, heap_far
    cdef int[::1] first, ends, near, scratch, found, via, heap_node, left, right, top, box_node, hole_at
    cdef int[::1] holes_first, hole_keys, hole_node, queue
    cdef int holes_start
    cdef bint holes_kept
    cdef long long[::1] seen, reached, done, wanted
    cdef list box_claim
    cdef dict stacks

    cdef void measure_truly(self)
    @cython.locals(look="long long", k=int, edge=int)
    cdef void look_from(self, int node) noexcept
    cdef void gather(self, int node) noexcept
    cpdef bint sees(self, int node, int other)
    @cython.locals(k=int, last=int)
    cpdef bint sees_box(self, int node)
    @cython.locals(k=int, found=list)
    cpdef list boxes(self, int node)

    @cython.locals(count=int, k=int)
    cpdef tuple holes(self, int node)
    @cython.locals(count=int, key=int)
    cdef int find_holes(self, int node) noexcept
    @cython.locals(filled="int[::1]", found="int[::1]", total="long long", count=int, k=int, node=int, key=int)
    cpdef fill_holes(self, holes)
    @cython.locals(look="long long", count=int, edge=int, i=int, onward=int, j=int, k=int)
    cpdef int around(self, int node)

    @cython.locals(at=int, base=double, edge=int, j=int, count=int)
    cpdef int pushes(self, int node, int box, int barred, int[::1] found)
    @cython.locals(
        search="long long", left=int, k=int, at=int, box=int, claim=int, room=int, head=int, tail=int,
        best=double, best_node=int, best_first=int, far=double, i=int, first=int, here=double, there=double, edge=int, j=int, through=double, step=int,
    )
    cpdef (int, int) nearest_box(
        self, int agent, int node, double level, int shunned, int barred, others=*, bint past=*, bytearray missed=*
    ) except *
    @cython.locals(box=int, claim=int)
    cdef bint takes(self, int agent, double level, int edge, bytearray missed) except? -1
    @cython.locals(base=double, edge=int, i=int, here=double, box=int)
    cdef bint graspable(self, int at, int node, double level, bint past) noexcept
    @cython.locals(search="long long", at=int, base=double, far=double, i=int, here=double, edge=int, j=int, through=double)
    cpdef tuple way_to(self, int node, int box, int end, int barred, avoided)
    @cython.locals(n=int, m=int, step=int)
    cdef bint earlier(self, int i, int k, int j) noexcept
    @cython.locals(place=int)
    cdef tuple traced(self, int node)
    @cython.locals(count=int, i=int, place=int)
    cdef int trace(self, int node, int[::1] way) noexcept

    @cython.locals(dx=double, dy=double, most=double, both=double)
    cdef double ahead(self, int i, int j) noexcept
    cdef long long start(self, int node, double ahead) noexcept
    @cython.locals(place=int, above=int)
    cdef void offer(self, double far, double ahead, int node, int via) noexcept
    @cython.locals(count=int, place=int, far=double, node=int, below=int)
    cdef void pop(self) noexcept
