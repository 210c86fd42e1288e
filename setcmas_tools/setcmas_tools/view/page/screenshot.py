"""Screenshots: what a browser shows, without what is empty around it, under a title."""

from __future__ import annotations

import io
import time
from pathlib import Path

import matplotlib as mpl
import viser
from PIL import Image, ImageChops, ImageDraw, ImageFont

_TIMEOUT_S = 15.0
_FONT = Path(mpl.get_data_path(), 'fonts', 'ttf', 'DejaVuSans.ttf')
_LETTERS = 0.022  # of the width
_LEAST_LETTERS_PX = 12


def take_screenshot(client: viser.ClientHandle | None, title: str) -> None:
    """Let a browser save what it shows; one that is closed meanwhile wants it no more."""
    if client is None:
        return
    camera = client.camera
    try:
        pixels = client.get_render(
            camera.image_height, camera.image_width, transport_format='png', timeout=_TIMEOUT_S
        )
    except TimeoutError:
        client.add_notification('No screenshot', 'The browser was too slow to draw it.')
        return
    except RuntimeError:  # it is closed, or cannot draw
        return
    content = io.BytesIO()
    titled(on_white(Image.fromarray(pixels)), title).save(content, 'png')
    name = time.strftime('setcmas_%Y%m%d-%H%M%S.png')
    client.send_file_download(name, content.getvalue(), save_immediately=True)


def on_white(drawn: Image.Image) -> Image.Image:
    """Return a picture on white ground, without what is white around it."""
    picture = Image.new('RGBA', drawn.size, 'white')
    picture.alpha_composite(drawn.convert('RGBA'))
    flat = picture.convert('RGB')
    filled = ImageChops.difference(flat, Image.new('RGB', flat.size, 'white')).getbbox()
    return flat.crop(filled) if filled else flat


def titled(picture: Image.Image, title: str) -> Image.Image:
    """Return a picture with a margin, and its title above it."""
    letters = max(_LEAST_LETTERS_PX, round(_LETTERS * picture.width))
    result = Image.new('RGB', (picture.width + 2 * letters, picture.height + 4 * letters), 'white')
    result.paste(picture, (letters, 3 * letters))
    font = ImageFont.truetype(_FONT, letters)
    ImageDraw.Draw(result).text((letters, letters), title, 'black', font)
    return result
