"""The steady motion under a force beside the parametric one: response, gain, and the noise that comes out."""

from __future__ import annotations

from floquetrod.responses.forces import Force
from floquetrod.responses.gain import Gain, gain
from floquetrod.responses.output_noise import OutputNoise, output_noise
from floquetrod.responses.steady_response import Response, response

__all__ = ["Force", "Gain", "OutputNoise", "Response", "gain", "output_noise", "response"]
