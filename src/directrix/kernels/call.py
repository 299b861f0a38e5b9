"""Calling machine code by its address from compiled loops."""
# pyright: basic

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["call_kernel"]


@intrinsic
def call_kernel(typing_context, address, x, p, first, g, out):
    """Run the kernel at ``address`` on (x, p[first:], g, out), all float64 arrays.

    The address is a run-time value, so one compiled and cached loop serves every element.
    """

    def codegen(context, builder, signature, args):
        def data(k):
            return context.make_array(signature.args[k])(context, builder, args[k]).data

        double = ir.DoubleType().as_pointer()
        kernel = ir.FunctionType(ir.VoidType(), [double] * 4).as_pointer()
        function = builder.inttoptr(args[0], kernel)
        parameters = builder.gep(data(2), [args[3]])
        builder.call(function, [data(1), parameters, data(4), data(5)])
        return context.get_dummy_value()

    return types.none(types.int64, x, p, types.int64, g, out), codegen
