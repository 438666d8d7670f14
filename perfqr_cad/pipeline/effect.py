"""Settings that have no effect without another: refused before any work, since somebody meant one by them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.kinds import Value, shown
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.remedy import Remedy


def require_effect(settings: Sequence[Parameter], given: Mapping[str, Value]) -> None:
    """Raises `DesignError` for a setting, other than its default, without any of the settings that it needs.

    given   values by name
    """
    declared = {setting.name: setting for setting in settings}

    def met(need: str) -> bool:
        name, equals, wanted = need.partition("=")
        return given[name] == wanted if equals else given[name] != declared[name].default

    for setting in settings:
        needs = [need for need in setting.needs if not need.startswith(".")]
        if needs and given[setting.name] != setting.default and not any(map(met, needs)):
            raise _without_effect(setting, given[setting.name], needs)


def require_files(settings: Sequence[Parameter], given: Mapping[str, Value], suffixes: Set[str]) -> None:
    """Raises `DesignError` for a setting, other than its default, of files of which none is written."""
    for setting in settings:
        needs = [need for need in setting.needs if need.startswith(".")]
        if needs and given[setting.name] != setting.default and suffixes.isdisjoint(needs):
            raise _without_effect(setting, given[setting.name], needs)


def _without_effect(setting: Parameter, value: Value, needs: Sequence[str]) -> DesignError:
    words = [f"a {need} file" if need.startswith(".") else need for need in needs]
    lacking = f"{', '.join(words[:-1])} or {words[-1]}" if len(words) > 1 else words[0]
    return DesignError(
        f"{setting.name}={shown(value)} has no effect without {lacking}",
        *([_giving(needs[0])] if len(needs) == 1 else []),
        Remedy(**{setting.field: None}),
    )


def _giving(need: str) -> Remedy | str:
    """What gives it an effect."""
    if need.startswith("."):
        return f"-o part{need}"
    name, equals, wanted = need.partition("=")
    return Remedy(**{name: wanted}) if equals else f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
