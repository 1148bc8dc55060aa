"""Behind one's own name: who is signed in, the way out, and tokens for programs."""

from __future__ import annotations

from functools import partial

from nicegui import ui

from deltactl.foundation.errors import ConfigError
from deltactl.web.access.tokens import Tokens
from deltactl.web.access.users import Session, asking
from deltactl.web.style import labelled, marked, tell_problem

SAYS = "A token lets a program use /api/v1 as you. It is shown once."


class UserMenu:
    """Opens at a click on the name, and ends nothing by itself."""

    def __init__(self, session: Session, tokens: Tokens | None):
        name = ui.button(session.name, icon="person").props("flat dense no-caps color=white")
        with name.props("data-testid=user"), ui.menu().classes("p-3"):
            ui.label(f"Signed in as {session.name}, {session.role}.")
            with ui.element("form").props('method=post action="/logout"'):
                out = ui.button("Sign out", icon="logout").props("type=submit flat no-caps")
                out.props("data-testid=sign-out")
            if tokens is not None:
                TokensOfUser(tokens, session.name)


class TokensOfUser:
    """A part of the menu; everything is asked of the session that presses."""

    def __init__(self, tokens: Tokens, name: str):
        self._tokens, self._user = tokens, name
        ui.separator()
        ui.label("Tokens for programs").classes("font-bold text-sm")
        ui.label(SAYS).classes("text-xs text-gray-600 max-w-xs")
        self._label = ui.input("What for").props("dense").classes("w-full")
        self._looks = ui.checkbox("may only look and stop").props("dense").classes("w-full")
        make = ui.button("Make a token", icon="key", on_click=self._make)
        make.props("no-caps dense outline data-testid=make-token").classes("px-2")
        self._shown = ui.label().classes("font-mono text-xs break-all max-w-xs select-all")
        marked(self._shown, "token")
        self._list = ui.column().classes("gap-0 w-full")
        self._write()

    def _write(self) -> None:
        self._list.clear()
        with self._list:
            for token in self._tokens.of(self._user):
                with ui.row().classes("items-center gap-2 no-wrap w-full"):
                    ui.label(f"{token.label} ({token.role})").classes("grow text-sm ellipsis")
                    end = ui.button(icon="close", on_click=partial(self._end, token.sha256))
                    labelled(end.props("flat dense round size=sm"), f"take back {token.label}")

    def _make(self) -> None:
        session = asking()
        if session is None or session.name != self._user:
            return
        try:
            label, looks = str(self._label.value or ""), bool(self._looks.value)
            word = self._tokens.make(self._user, label, looks)
        except ConfigError as error:
            tell_problem(str(error))
            return
        self._shown.set_text(word)
        self._write()

    def _end(self, sha256: str) -> None:
        session = asking()
        if session is not None and session.name == self._user:
            self._tokens.take_back(self._user, sha256)
            self._write()
