"""Images that mesh files name, found where Gazebo's models have them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from urllib.parse import unquote

from libgz.base.errors import NotFoundError
from libgz.base.files import is_file
from libgz.base.visible import one_line
from libgz.physics.mesh_parts import NamedImage, Texture
from libgz.sdf.paths import find_uri

__all__ = ["find_image", "found_images"]


def found_images(textures: Iterable[Texture], note: Callable[[str], object]) -> dict[NamedImage, Path]:
    """The files of images of a mesh.

    Args:
        textures: of its parts.
        note: called once with what is wrong with each image that is missing, or has no place on a part.
    """
    given, found = list(textures), dict[NamedImage, Path]()
    for image in dict.fromkeys(texture.image for texture in given if texture.image is not None):
        try:
            found[image] = find_image(image)
        except NotFoundError as error:
            note(f"{error}; rendered without a texture")
    for bare in dict.fromkeys(texture.image for texture in given if texture.coordinates is None):
        if bare is not None and bare in found:
            why = f"a part of the mesh has no usable texture coordinates for image {bare.name} of {bare.file}"
            note(f"{why}; rendered without a texture")
    return found


def find_image(image: NamedImage) -> Path:
    """The file of an image: beside the file that names it, or in `../materials/textures`.

    It may be a `model://` URI. Of a path that exists on no other computer the last part is tried, too.

    Raises:
        NotFoundError: it does not exist; the message lists the places tried.
    """
    folder, written = image.file.parent, image.name
    folders = (folder, folder.parent / "materials" / "textures")
    if written.startswith(("model://", "package://")):
        return find_uri(written, folder)
    plain = written.removeprefix("file://").replace("\\", "/")
    names = [plain, unquote(plain), unquote(plain).rpartition("/")[2]]
    places = [place / name for name in names if name for place in folders]
    for place in places:
        if is_file(place):
            return place
    tried = one_line(", ".join(dict.fromkeys(map(str, places))))
    raise NotFoundError(f"image {one_line(written)} of {image.file} was not found; looked for {tried}")
