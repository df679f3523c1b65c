"""Comments of files that are copied, in time that grows with their number."""

from lxml import etree

from libgz.sdf.reader import SdfFile
from libgz.sdfworld.comments import copy_comments

MANY = 20_000


def test_thousands_of_comments_are_copied_at_once(tmp_path):
    comments = "".join(f"<!--{i}-->\n" for i in range(MANY))
    path = tmp_path / "model.sdf"
    path.write_text(f"<sdf version='1.6'><model name='m'>\n{comments}<link name='l'/></model></sdf>")
    model = SdfFile.load(path).root.child("model")
    copy_comments(model, etree.fromstring("<include/>"))  # which would take minutes if it were the square
    assert model.child("link").comments == tuple(map(str, range(MANY)))
