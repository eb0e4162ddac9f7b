# cython: language_level=3, boundscheck=False, wraparound=False
"""Rows that become columns as they come, in C; where it was not compiled a list of tuples does the same, more slowly."""

cimport cython
from cpython cimport array
from cpython.number cimport PyNumber_Index
from cpython.object cimport Py_SIZE
import array

cdef array.array LONGS = array.array("q")
cdef array.array DOUBLES = array.array("d")
cdef array.array BYTES = array.array("b")
cdef dict KINDS = {"int": 0, "float": 1, "text": 2, "bool": 3, "ints": 4, "floats": 5}


@cython.final
cdef class _Column:
    """One column: its kind, its values so far, and for a list column how many belong to each row."""

    def __cinit__(self, kind, codes):
        self.kind = KINDS[kind]
        self.codes = codes
        self.text = None
        self.start()

    cdef start(self):
        cdef array.array like = LONGS
        if self.kind == 1 or self.kind == 5:
            like = DOUBLES
        elif self.kind == 3:
            like = BYTES
        self.values = array.clone(like, 0, False)
        self.sizes = array.clone(LONGS, 0, False) if self.kind > 3 else None

    cdef int put(self, value) except -1:
        cdef long long whole  # only by way of its index: a float must not be cut off in an integer column
        cdef double number
        cdef Py_ssize_t n = Py_SIZE(self.values)
        if self.kind == 1:
            number = value
            array.resize_smart(self.values, n + 1)
            self.values.data.as_doubles[n] = number
        elif self.kind == 0 or self.kind == 2:
            whole = PyNumber_Index(value if self.kind == 0 else self.codes[value])
            array.resize_smart(self.values, n + 1)
            self.values.data.as_longlongs[n] = whole
        elif self.kind == 3:
            whole = 1 if value else 0
            array.resize_smart(self.values, n + 1)
            self.values.data.as_schars[n] = <signed char> whole
        else:
            for item in value:
                if self.kind == 4:
                    whole = PyNumber_Index(item)
                    array.resize_smart(self.values, n + 1)
                    self.values.data.as_longlongs[n] = whole
                else:
                    number = item
                    array.resize_smart(self.values, n + 1)
                    self.values.data.as_doubles[n] = number
                n += 1
            self.size(len(value))
        return 0

    cdef int size(self, Py_ssize_t count) except -1:
        cdef array.array sizes = self.sizes
        cdef Py_ssize_t n = Py_SIZE(sizes)
        array.resize_smart(sizes, n + 1)
        sizes.data.as_longlongs[n] = count
        return 0


@cython.final
cdef class Block:
    """A table's next rows: whole ones by `append`, or value by value in the order of the columns.

    Args:
        table: Name of the table, for messages.
        columns: Kind of each column by name, see `schema.TABLES`.
        codes: For each column the numbers of its texts.
    """

    def __init__(self, table, columns, codes):
        self.table = table
        self.names = list(columns)
        self.columns = [_Column(kind, codes[name]) for name, kind in columns.items()]
        self.rows = self.at = 0

    def __len__(self):
        return self.rows

    cpdef append(self, row):
        """Takes one row, all of it or, if a value does not fit, nothing.

        Raises:
            ValueError: It has another number of values than the table has columns.
            TypeError: A value does not fit its column.
        """
        cdef Py_ssize_t i
        cdef _Column column
        if not isinstance(row, tuple) or len(row) != len(self.columns):
            raise ValueError(f"{self.table}: {len(row)} values in a row of {len(self.columns)} columns")
        for i in range(len(self.columns)):
            column = <_Column> self.columns[i]
            try:
                column.put((<tuple> row)[i])
            except TypeError as error:
                self._back_to(self.rows)
                raise TypeError(f"{self.table}.{self.names[i]}: {error}") from error
            except BaseException:
                self._back_to(self.rows)
                raise
        self.rows += 1

    # The following take one value each for the next column; they trust their caller with its kind. The last one of
    # a row ends it.

    cdef inline _Column next(self):
        cdef _Column column = <_Column> self.columns[self.at]
        self.at += 1
        if self.at == len(self.columns):
            self.at = 0
            self.rows += 1
        return column

    cdef int whole(self, long long value) except -1:
        self.item(value)
        self.next()
        return 0

    cdef int real(self, double value) except -1:
        self.real_item(value)
        self.next()
        return 0

    cdef int flag(self, bint value) except -1:
        cdef array.array values = self.next().values
        cdef Py_ssize_t n = Py_SIZE(values)
        array.resize_smart(values, n + 1)
        values.data.as_schars[n] = value
        return 0

    cdef int word(self, str value) except -1:
        cdef _Column column = <_Column> self.columns[self.at]
        if value is not column.text:
            column.code = column.codes[value]
            column.text = value
        return self.whole(column.code)

    # A list column takes its numbers one by one, then their count.

    cdef int item(self, long long value) except -1:
        cdef array.array values = (<_Column> self.columns[self.at]).values
        cdef Py_ssize_t n = Py_SIZE(values)
        array.resize_smart(values, n + 1)
        values.data.as_longlongs[n] = value
        return 0

    cdef int real_item(self, double value) except -1:
        cdef array.array values = (<_Column> self.columns[self.at]).values
        cdef Py_ssize_t n = Py_SIZE(values)
        array.resize_smart(values, n + 1)
        values.data.as_doubles[n] = value
        return 0

    cdef int items(self, Py_ssize_t count) except -1:
        return self.next().size(count)

    cdef _back_to(self, Py_ssize_t rows):
        cdef _Column column
        for column in self.columns:
            if column.sizes is None:
                del column.values[rows:]
            else:
                del column.sizes[rows:]
                del column.values[sum(column.sizes):]

    def take(self):
        """The columns so far as (values, sizes or None) by name; the next row begins new ones."""
        cdef _Column column
        taken = {}
        for name, column in zip(self.names, self.columns):
            taken[name] = (column.values, column.sizes)
            column.start()
        self.rows = 0
        return taken
