"""How environments are shown: images for whoever asks for one, or a window that follows by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.installing import install_command
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

__all__ = ["RENDER_MODES", "Rendering"]

RENDER_MODES = ("human", "rgb_array")
"""As Gymnasium and PettingZoo have them: a window, or images."""


class Rendering:
    """What an environment shows of itself in a render mode.

    Args:
        mode: One of `RENDER_MODES`, or None: nothing is shown.
        title: What stands above the window.
        fps: Most images a second that the window shows, of wall-clock time.

    Raises:
        ColonysimError: There is no such mode.
        MissingExtraError: A window is asked for, and pygame is not installed.
    """

    def __init__(self, mode: str | None, title: str, fps: float) -> None:
        if mode is not None and mode not in RENDER_MODES:
            raise ColonysimError(f"no render mode {mode!r}; {nearest(str(mode), RENDER_MODES)}")
        self._mode, self._window = mode, _Window(title, fps) if mode == "human" else None

    def follow(self, draw: Callable[[], NDArray[np.uint8]]) -> None:
        """To be called after each reset and step: the window shows the state.

        Args:
            draw: Makes an image of it: red, green and blue; shape (height, width, 3).
        """
        if self._window is not None:
            self._window.show(draw())

    def render(self, draw: Callable[[], NDArray[np.uint8]]) -> NDArray[np.uint8] | None:
        """What an environment's `render` returns: an image, if the mode is to give images."""
        self.follow(draw)
        return draw() if self._mode == "rgb_array" else None

    def close(self) -> None:
        """Closes the window, if there is one."""
        if self._window is not None:
            self._window.close()


class _Window:
    """A window of pygame, as Gymnasium's own environments have it, which opens with its first image.

    A process has one: whoever shows something has it then.
    """

    def __init__(self, title: str, fps: float) -> None:
        try:
            import pygame
        except ImportError as error:
            raise MissingExtraError(
                f"render_mode='human' needs pygame ({error}): {install_command('window')}"
            ) from error
        self._pygame, self._title, self._fps = pygame, title, fps
        self._clock: Any = pygame.time.Clock()
        self._open = False

    def show(self, image: NDArray[np.uint8]) -> None:
        """Shows an image, and waits until the one before has been there for its time."""
        pygame, size = self._pygame, (image.shape[1], image.shape[0])
        try:
            pygame.display.init()
            surface = pygame.display.get_surface()
            if surface is None or surface.get_size() != size:
                surface = pygame.display.set_mode(size)
        except pygame.error as error:
            raise ColonysimError(
                f"no window can be opened here ({error}); render_mode='rgb_array' gives images without one"
            ) from error
        self._open = True
        pygame.display.set_caption(self._title)
        pygame.surfarray.blit_array(surface, image.swapaxes(0, 1))
        pygame.event.pump()  # or the desktop thinks that it hangs
        self._clock.tick(self._fps)
        pygame.display.flip()

    def close(self) -> None:
        """Closes it; the next image opens it again."""
        if self._open:
            self._pygame.display.quit()
            self._open = False
