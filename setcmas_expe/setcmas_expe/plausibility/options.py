"""Options of processes that prove which body is which robot."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_expe.lab.model import Lab
from setcmas_expe.plausibility.proofs import Proofs
from setcmas_simu.options.group import Options, flag


@dataclass(frozen=True, kw_only=True)
class ProofOptions(Options):
    """Whether proofs count."""

    emulated: bool = flag('the lab is emulated: no proof from before counts, and none is kept')

    def proofs(self, lab: Lab) -> Proofs | None:
        """Return what was proved of a lab; None if nothing counts."""
        return None if self.emulated else Proofs(lab)
