"""Asking the runtime's fence about a request before it is made."""

from __future__ import annotations

from . import _host
from .outcomes import Refusal
from .requests import Request


def check(request: Request) -> float | Refusal:
    """Whether a request's geometry would pass the runtime's check with the navigation of this step.

    Returns the clearance in metres, at most 1000, or the ``Refusal`` that the runtime would give. The check does not
    know of control, rates, other leases or the vehicle's plan, so the runtime may refuse a request that passes here.
    Each call costs 10,000 units of fuel. Without a runtime there is no fence, and the answer is a refusal.
    """
    return _host.current.check(request)


def allows(request: Request) -> bool:
    """Whether ``check`` gives a clearance."""
    return not isinstance(check(request), Refusal)
