"""The steady motion under a force beside the parametric one: response, gain, and the noise that comes out."""

from __future__ import annotations

from floquetrod.responses.forces import Force
from floquetrod.responses.steady_response import Response, response

__all__ = ["Force", "Response", "response"]
