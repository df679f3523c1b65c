"""Image files: what pillow thinks of a damaged one does not fill the log."""

import struct
import warnings

import pytest

from libgz.base.errors import GazeboError
from libgz.physics.image_files import open_image


def test_damaged_tags_of_a_tiff_cause_no_warnings(tmp_path):
    count = 500
    tags = b"".join(struct.pack("<HHII", 1000 + k, 2, 1 << 30, 8) for k in range(count))
    path = tmp_path / "a.tif"
    path.write_bytes(struct.pack("<2sHIH", b"II", 42, 8, count) + tags + bytes(4))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with pytest.raises(GazeboError, match=r"a\.tif cannot be read"), open_image(path):
            pass
    assert not caught
