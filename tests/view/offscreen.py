"""Whether MuJoCo can draw here."""

import pytest

from cartgrasp.errors import UsageError
from cartgrasp.view.rendering import offscreen


def has_opengl() -> bool:
    try:
        offscreen().free()
    except UsageError:
        return False
    return True


needs_opengl = pytest.mark.skipif(not has_opengl(), reason="no OpenGL here that draws without a display")
