"""Calling machine code by its address from compiled loops."""
# pyright: basic

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["FACTORS", "add_block", "call_elimination", "call_kernel", "call_lanes"]

FACTORS = 56  # what the elimination leaves of a row


@intrinsic
def call_kernel(typing_context, address, x, at, first_at, p, first_p, g, out):
    """Run the element kernel at ``address`` on (x, at[first_at:], p[first_p:], g, out): ``at`` int64, the rest float.

    The address is a run-time value, so one compiled and cached loop serves every element.
    """

    def codegen(context, builder, signature, args):
        def data(k):
            return context.make_array(signature.args[k])(context, builder, args[k]).data

        double, whole = ir.DoubleType().as_pointer(), ir.IntType(64).as_pointer()
        kernel = ir.FunctionType(ir.VoidType(), [double, whole, double, double, double]).as_pointer()
        function = builder.inttoptr(args[0], kernel)
        places, parameters = builder.gep(data(2), [args[3]]), builder.gep(data(4), [args[5]])
        builder.call(function, [data(1), places, parameters, data(6), data(7)])
        return context.get_dummy_value()

    return types.none(types.int64, x, at, types.int64, p, types.int64, g, out), codegen


@intrinsic
def call_elimination(typing_context, address, blocks, block, rhs, row, factors, factor):
    """Run the elimination at ``address`` on blocks[block:], the factors before, rhs[row:] and factors[factor:]."""

    def codegen(context, builder, signature, args):
        def data(k):
            return context.make_array(signature.args[k])(context, builder, args[k]).data

        double = ir.DoubleType().as_pointer()
        kernel = ir.FunctionType(ir.VoidType(), [double] * 4).as_pointer()
        row, rhs, out = (builder.gep(data(k), [args[k + 1]]) for k in (1, 3, 5))
        before = builder.gep(out, [ir.Constant(ir.IntType(64), -FACTORS)])
        builder.call(builder.inttoptr(args[0], kernel), [row, before, rhs, out])
        return context.get_dummy_value()

    whole = types.int64
    return types.none(whole, blocks, whole, rhs, whole, factors, whole), codegen


@intrinsic
def add_block(typing_context, to, at, values, first):
    """to[at : at + 36] += values[first : first + 36], in vectors: the two arrays do not overlap."""

    def codegen(context, builder, signature, args):
        def vector(k, lanes, place):
            array = context.make_array(signature.args[k])(context, builder, args[k]).data
            start = builder.gep(array, [builder.add(args[k + 1], ir.Constant(ir.IntType(64), place))])
            return builder.bitcast(start, ir.VectorType(ir.DoubleType(), lanes).as_pointer())

        sums = []
        for place, lanes in ((0, 8), (8, 8), (16, 8), (24, 8), (32, 4)):
            target = vector(0, lanes, place)
            value = builder.load(vector(2, lanes, place), align=8)
            sums.append((builder.fadd(builder.load(target, align=8), value), target))
        for value, target in sums:
            builder.store(value, target, align=8)
        return context.get_dummy_value()

    return types.none(to, types.int64, values, types.int64), codegen


@intrinsic
def call_lanes(typing_context, address, arrays, first):
    """Run the function at ``address`` (see :mod:`directrix.kernels.lanes`) on ``arrays[k][first[k]:]``, all flat."""

    def codegen(context, builder, signature, args):
        pointers = []
        for k, kind in enumerate(signature.args[1].types):
            array = context.make_array(kind)(context, builder, builder.extract_value(args[1], k))
            pointers.append(builder.gep(array.data, [builder.extract_value(args[2], k)]))
        double = ir.DoubleType().as_pointer()
        function = ir.FunctionType(ir.VoidType(), [double] * len(pointers)).as_pointer()
        builder.call(builder.inttoptr(args[0], function), pointers)
        return context.get_dummy_value()

    return types.none(types.int64, arrays, types.UniTuple(types.int64, len(arrays))), codegen
