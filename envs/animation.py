"""Animations of trajectories."""

from collections.abc import Sequence
from pathlib import Path

from PIL.Image import Dither, Image
from PIL.Image import new as new_image

from bpns.symbolic.errors import InputError
from bpns.symbolic.files import replacing
from bpns.symbolic.skills.environment import Environment
from bpns.symbolic.state import Features, State
from bpns.symbolic.structs import GroundAtom

FRAMES_PER_ACTION = 8
MAX_FRAMES = 800  # long trajectories get fewer frames between their states
FRAME_MILLISECONDS = 50
PAUSE_MILLISECONDS = 1500  # on the last frame
COLORS, PALETTE_STATES = 128, 8
FORMATS = {".gif": "GIF", ".webp": "WEBP", ".png": "PNG"}


def animation_format(path: Path) -> str:
    """Return Pillow's name for a file's format; raise InputError where it cannot hold an animation."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"cannot write an animation as '{path.name}': use .gif, .webp or .png")
    return FORMATS[path.suffix.lower()]


def write_animation(
    path: Path,
    environment: Environment,
    states: Sequence[State],
    captions: Sequence[str],
    goal: frozenset[GroundAtom],
) -> None:
    """Write a GIF, WebP or animated PNG; ``captions`` has one text for each state."""
    kind = animation_format(path)
    frames: list[Image] = []
    palette = None
    if kind == "GIF":
        palette = _palette([environment.draw(state, "", goal) for state in _spread(states)])
    durations: list[int] = []

    def add(state: State, caption: str) -> None:
        """Draw a frame; a GIF's are kept in few colors, a third of the memory."""
        frame = environment.draw(state, caption, goal)
        if palette is not None:
            frame = frame.quantize(palette=palette, dither=Dither.NONE)
        frames.append(frame)

    blends = max(1, min(FRAMES_PER_ACTION, MAX_FRAMES // len(states)))
    for number, state in enumerate(states):
        add(state, captions[number])
        durations.append(FRAME_MILLISECONDS * 4)  # a moment at every real state
        if number + 1 < len(states):
            for step in range(1, blends):
                add(_between(state, states[number + 1], step / blends), captions[number])
                durations.append(FRAME_MILLISECONDS)
    durations[-1] = PAUSE_MILLISECONDS
    with replacing(path) as temporary:
        frames[0].save(temporary, kind, save_all=True, append_images=frames[1:], duration=durations, loop=0)


def _spread(states: Sequence[State]) -> list[State]:
    """Return some states from the first to the last."""
    count = min(PALETTE_STATES, len(states))
    return [states[i * (len(states) - 1) // max(1, count - 1)] for i in range(count)]


def _palette(pictures: Sequence[Image]) -> Image:
    """Return colors that serve all pictures: what is there at the end may not be there at the start."""
    width, height = pictures[0].size
    together = new_image("RGB", (width * len(pictures), height))
    for number, picture in enumerate(pictures):
        together.paste(picture, (number * width, 0))
    return together.quantize(COLORS)


def _between(first: State, second: State, share: float) -> State:
    """Blend two states; features that jump between whole numbers (flags) wait for the second state."""

    def blend(a: float, b: float) -> float:
        return a if a.is_integer() and b.is_integer() else a + share * (b - a)

    changes: dict[str, Features] = {
        name: tuple(blend(a, b) for a, b in zip(values, second.features[name], strict=True))
        for name, values in first.features.items()
        if values is not second.features[name]
    }
    return first.changed(changes)
