# The types of presets.py when it is compiled.
from colonysim.policies.stigmergy cimport Stigmergy


cdef class Colony(Stigmergy):
    pass


cdef class Paper(Colony):
    pass


cdef class Oracle(Colony):
    pass
