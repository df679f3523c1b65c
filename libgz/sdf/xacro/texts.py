"""Texts of attributes and elements: `${expressions}`, `$(substitutions)`, and what stands between."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from libgz.sdf.xacro.expressions import Evaluator
from libgz.sdf.xacro.limits import ExpansionError, LimitError
from libgz.sdf.xacro.operations import text_of
from libgz.sdf.xacro.scopes import Scope

__all__ = ["Texts"]

# A dollar sign that is doubled before a bracket stands for itself; one before other characters, too.
_TOKEN = re.compile(
    r"(?P<escape>\$\$+[{(])|(?P<expression>\$\{[^}]*\})|(?P<substitution>\$\([^)]*\))|(?P<text>[^$]+|\$[^{($]+|\$\Z)"
)


class Texts:
    """Evaluates texts.

    Args:
        evaluator: of their expressions.
        substitute: gives the text of the words of a substitution, such as `find NAME`.
    """

    def __init__(self, evaluator: Evaluator, substitute: Callable[[str], str]) -> None:
        self.evaluator, self.substitute = evaluator, substitute

    def value(self, text: str, scope: Scope) -> Any:
        """The value of a text: that of its expression, if it is nothing else, or a text.

        Raises:
            ExpansionError: an expression or substitution is wrong.
        """
        if "$" not in text:
            return text
        values: list[Any] = []
        at = 0
        while at < len(text):
            token = _TOKEN.match(text, at)
            if token is None:
                raise ExpansionError(f"invalid expression: {text[at : at + 80]}")
            values.append(self._of_token(token, scope))
            at = token.end()
        if len(values) == 1:
            return values[0]
        return self._joined(values)

    def text(self, text: str, scope: Scope) -> str:
        """The same as a text, as it is printed."""
        return text if "$" not in text else text_of(self.evaluator.budget, self.value(text, scope))

    def _of_token(self, token: re.Match[str], scope: Scope) -> Any:
        inside = token[0][2:-1]
        if token["escape"] is not None:
            return token[0][1:]
        if token["expression"] is not None:
            try:
                return self.evaluator.evaluate(self.text(inside, scope), scope)
            except ExpansionError as error:
                raise _about(error, f"in the expression '{inside.strip()[:200]}'") from None
        if token["substitution"] is not None:
            return self.substitute(self.text(inside, scope))
        return token[0]

    def _joined(self, values: list[Any]) -> str:
        budget = self.evaluator.budget
        parts = [text_of(budget, value) for value in values]
        budget.length(sum(map(len, parts)))
        return "".join(parts)


def _about(error: ExpansionError, where: str) -> ExpansionError:
    """An error with the expression that it is in; the innermost one is enough."""
    text = str(error)
    kind = LimitError if isinstance(error, LimitError) else ExpansionError
    return kind(text if ", in the expression '" in text else f"{text}, {where}")
