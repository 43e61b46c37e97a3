"""How a page is opened in Chromium."""

from pathlib import Path
from typing import Any


def visit(
    driver: Any, path: Path, *, width: int = 1200, dark: bool = False, script: bool = True
) -> None:
    """Open a page, in a window of this width, on a light or a dark desktop."""
    driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500},
    )
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    for kind in ("browser", "performance"):
        driver.get_log(kind)
    driver.get(path.as_uri())
    if script:
        # the pictures are drawn when their size is known: after the next frame
        driver.execute_async_script(
            "requestAnimationFrame(() => requestAnimationFrame(arguments[0]))"
        )
