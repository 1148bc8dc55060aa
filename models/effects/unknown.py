"""An error without a name: what to do about it, by what it follows."""

from __future__ import annotations

from deltactl.models.effects.card import EffectCard, Words

CARD = EffectCard(
    name="unknown",
    log_odds={
        # a slip of an axis that counts no steps, at one moment of all there were
        "slip/jump": -6.0,
        # warmth has a name on other machines, none on an axis
        "command/drift": -4.0,
        # machines have a cable or a spring at the axis by design, and then it is in the file
        "effort/spring": -4.0,
        # three joints have three times as many covariates as one axis, which has -5
        "joint": -6.0,
    },
    words=Words(
        noun="an unknown error at {part}",
    ),
    remedies={
        "": (
            "find out what the unknown error at {part} comes with: it follows {follows}; repeat the"
            " motion with that changed, and with all else as it was"
        ),
        "position": (
            "repeat the motion: an unknown error at {part} follows {follows}; where it comes back "
            "at the same places, look there for what is bent, loose or in the way"
        ),
        "speed": (
            "record {part} at several steady speeds, slow to fast, both ways: an unknown error "
            "follows {follows}, and such a recording shows how it depends on it"
        ),
        "direction": (
            "come to the same places from both sides: an unknown error at {part} follows {follows};"
            " play and friction leave the same difference everywhere, what yields leaves more under"
            " more load"
        ),
        "time": (
            "record again from switching on, with the same motion: an unknown error at {part} "
            "follows {follows}; what comes back is warming up, what does not came loose or moved"
        ),
        "load": (
            "repeat the motion with another weight: an unknown error at {part} follows {follows}, "
            "and what yields under load grows with the weight"
        ),
        "axis/position.force": (
            "repeat the motion: an unknown force of {part} follows {follows}; where it comes back "
            "at the same places, have the controller add a table of it (--json FILE writes one), or"
            " look there for what rubs or is bent"
        ),
        "axis/effort": (
            "record {part} with another load, and slower: an unknown part of the error follows "
            "{follows}; what the drive adds by itself stays, what the load does changes"
        ),
        "axis/direction.beside": (
            "move {part} to and fro by a little at several places along its travel, and record "
            "that: its friction or play differs from place to place (by about {size}), and such a "
            "recording shows where; look there for a worn gear, a cable that drags, or a weight"
        ),
        "sensor/": (
            "look at what {part} reads while nothing moves, and with another target: an unknown "
            "error follows {follows}; what changes with the target comes from it or its "
            "surroundings"
        ),
        "sensor/time": (
            "record {part} from switching on, before a target at rest: an unknown error "
            "follows {follows}; what comes back each time is warming up"
        ),
    },
)
