"""Calling machine code by its address from compiled loops."""
# pyright: basic

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["call_elimination", "call_kernel"]


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
def call_elimination(typing_context, address, row, before, rhs, out):
    """Run the elimination at ``address`` on (row, before, rhs, out), all float64 arrays."""

    def codegen(context, builder, signature, args):
        def data(k):
            return context.make_array(signature.args[k])(context, builder, args[k]).data

        double = ir.DoubleType().as_pointer()
        kernel = ir.FunctionType(ir.VoidType(), [double] * 4).as_pointer()
        builder.call(builder.inttoptr(args[0], kernel), [data(k) for k in range(1, 5)])
        return context.get_dummy_value()

    return types.none(types.int64, row, before, rhs, out), codegen
