"""The chain: counts -> motor -> gear -> arm -> linkage -> platform -> sensor -> clock.

The nominal robot is the chain with no effects. `Chain.delta(robot).simulate(commands, effects)`
computes a whole recording at once; `OnlineChain` goes on block by block with the same result.
"""

from deltactl.models.chain.active import Active, activate
from deltactl.models.chain.commands import Commands, Outputs
from deltactl.models.chain.delta import Chain, OnlineChain

__all__ = ["Active", "Chain", "Commands", "OnlineChain", "Outputs", "activate"]
