"""Threads that take the same steps, each for strips of its own: how they meet, and how they find the strips."""
# pyright: basic, reportCallIssue=false

from __future__ import annotations

import ctypes
import sys
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from directrix.kernels.compile import text_address
from directrix.kernels.expressions import Emitted, Expressions
from directrix.kernels.jit import inner
from directrix.kernels.kinds import Value
from directrix.kernels.record import Record

__all__ = ["STOP", "Team", "meet", "strip_at", "team_of"]

STOP, COUNT, GIVE_WAY = 8, 16, 17  # places of a gate beside the arrivals at 0, in lines of the cache of their own
PATIENCE = 4000  # looks at the gate before others may use the processor


class Team(Record):
    """One thread of ``many`` that share the strips of a chain: the addresses of ``all`` and of its ``own``. ``gate`` is
    common to them, ``met`` how often this one has been there, ``wait`` the address of the code for it."""

    many: int
    all: NDArray[np.int64]
    own: NDArray[np.int64]
    gate: NDArray[np.int64]
    met: NDArray[np.int64]
    wait: int


def team_of(strips: Sequence[Record], threads: int) -> list[Team]:
    """One for each thread; they hold addresses alone, so somebody else has to keep the strips."""
    addresses, gate = np.array([strip.address for strip in strips], np.int64), np.zeros(24, np.int64)
    gate[COUNT], gate[GIVE_WAY] = threads, _give_way()
    wait = text_address("gate", _gate) if threads > 1 else 0
    own = (addresses[me::threads].copy() for me in range(threads))
    return [Team(threads, addresses, mine, gate, np.zeros(1, np.int64), wait) for mine in own]


@cache
def _give_way() -> int:
    """Address of what lets other threads run."""
    library = ctypes.WinDLL("kernel32") if sys.platform == "win32" else ctypes.CDLL(None)
    function = library.SwitchToThread if sys.platform == "win32" else library.sched_yield
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _gate(name: str) -> str:
    return f"""define i64 @{name}(ptr %gate, ptr %met) {{
start:
  %count.at = getelementptr i64, ptr %gate, i64 {COUNT}
  %count = load i64, ptr %count.at
  %met.0 = load i64, ptr %met
  %met.1 = add i64 %met.0, 1
  store i64 %met.1, ptr %met
  %all = mul i64 %met.1, %count
  %before = atomicrmw add ptr %gate, i64 1 acq_rel
  %stop.at = getelementptr i64, ptr %gate, i64 {STOP}
  %yield.at = getelementptr i64, ptr %gate, i64 {GIVE_WAY}
  %yield.i = load i64, ptr %yield.at
  %yield = inttoptr i64 %yield.i to ptr
  br label %look
look:
  %looks = phi i64 [ 0, %start ], [ %more, %rest ]
  %here = load atomic i64, ptr %gate acquire, align 8
  %done = icmp sge i64 %here, %all
  br i1 %done, label %open, label %wait
wait:
  %stop = load atomic i64, ptr %stop.at acquire, align 8
  %stopped = icmp ne i64 %stop, 0
  br i1 %stopped, label %shut, label %patient
patient:
  %more = add i64 %looks, 1
  %long = icmp sgt i64 %looks, {PATIENCE}
  br i1 %long, label %away, label %rest
away:
  %ignored = call i32 %yield()
  br label %rest
rest:
  br label %look
open:
  ret i64 1
shut:
  ret i64 0
}}"""


def _wait(body: Expressions, given: Sequence[Value]) -> Value:
    address, gate, met = given
    function = body.put(f"inttoptr i64 {address.parts[0]} to ptr")
    here = body.put(f"call i64 {function}(ptr {gate.parts[0]}, ptr {met.parts[0]})")
    return Value("b", (body.put(f"icmp ne i64 {here}, 0"),))


_call_gate = Emitted(_wait)


@inner
def meet(team):
    """Wait for all threads of a team; False when they will not come."""
    if team.many == 1:
        return True
    return _call_gate(team.wait, team.gate, team.met)


def _strip(body: Expressions, given: Sequence[Value]) -> Value:
    addresses, k, like = given
    at = body.put(f"getelementptr inbounds i64, ptr {addresses.parts[0]}, i64 {k.parts[0]}")
    return Value(like.kind, (body.put(f"load ptr, ptr {at}, align 8"),))


strip_at = Emitted(_strip)
"""(addresses, k, like): the record at addresses[k], which has the fields of ``like``."""
