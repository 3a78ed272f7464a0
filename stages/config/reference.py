"""Every key of the config with its meaning: as YAML; config/schema.json and docs/config.md from the typed models."""

import json
import textwrap
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from roomkin.stages.config.model import complete
from roomkin.stages.plugins import KINDS, PACKAGES, find_options, list_available


def _scalar(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, width=10_000, sort_keys=False, allow_unicode=True)
    return text.removesuffix("\n...\n").rstrip("\n")


def _list_allowed(schema: dict[str, Any]) -> str:
    """Choices and bounds of a key, from its JSON schema."""
    parts = []
    options = [schema, *schema.get("anyOf", [])]
    for option in options:
        if "enum" in option:
            parts.append(" | ".join(str(choice) for choice in option["enum"]))
        if "kind" in option:
            parts.append(" | ".join([*list_available(option["kind"]), "yours"]))
    for key, sign in (("minimum", ">="), ("exclusiveMinimum", ">"), ("maximum", "<="), ("exclusiveMaximum", "<")):
        parts.extend(f"{sign} {option[key]}" for option in options if key in option)
    return ", ".join(parts)


def _lines(value: BaseModel, indent: str, path: str, rows: list[tuple[str, str, str, str]]) -> list[str]:
    """YAML lines of one section; `rows` collects (path, default, allowed, description) for the docs."""
    lines = []
    properties = type(value).model_json_schema()["properties"]
    for name, field in type(value).model_fields.items():
        child = getattr(value, name)
        description = field.description or ""
        allowed = _list_allowed(properties[name])
        comment = description + (f" [{allowed}]" if allowed else "")
        lines.extend(textwrap.wrap(comment, 110, initial_indent=f"{indent}# ", subsequent_indent=f"{indent}# "))
        key = f"{path}.{name}".lstrip(".")
        if isinstance(child, BaseModel):
            rows.append((key, "", "", description))
            lines += [f"{indent}{name}:", *_lines(child, indent + "  ", key, rows), ""]
            continue
        default = "" if field.default is PydanticUndefined and field.default_factory is None else _simplify_value(child)
        nested = isinstance(child, dict) and child and all(isinstance(item, BaseModel) for item in child.values())
        shown = f"{{{', '.join(f'{one}: ...' for one in child)}}}" if nested else _scalar(default)
        rows.append((key, shown, allowed, description))
        if nested:
            lines.append(f"{indent}{name}:")
            for item_name, item in child.items():
                lines += [f"{indent}  {item_name}:", *_lines(item, indent + "    ", f"{key}.{item_name}", rows)]
        elif isinstance(default, dict) and len(_scalar(default)) > 100:
            lines.append(f"{indent}{name}:")
            lines += [f"{indent}  {item_name}: {_scalar(item)}" for item_name, item in default.items()]
        else:
            lines.append(f"{indent}{name}: {_scalar(default)}")
    return lines


def _simplify_value(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, dict):
        return {key: _simplify_value(item) for key, item in value.items()}
    return [_simplify_value(item) for item in value] if isinstance(value, list | tuple) else value


def write_yaml(config: BaseModel) -> str:
    """A config as YAML: every key with its value, what it means and what is allowed."""
    return "\n".join(_lines(config, "", "", [])).rstrip() + "\n"


def _row(key: str, default: str, allowed: str, description: str) -> str:
    allowed, description = (text.replace("|", "\\|").replace("\n", " ") for text in (allowed, description))
    return f"| `{key}` | `{default}` | {allowed} | {description} |"


def _list_kwargs() -> list[str]:
    """Lines with the options of every implementation of ours that has some."""
    packages = [f"roomkin.plugins.{path.name}" for path in sorted(PACKAGES.glob("[!_]*/"))]
    lines: list[str] = []
    for kind in KINDS:
        for name, module in list_available(kind, packages).items():
            rows: list[tuple[str, str, str, str]] = []
            _lines(find_options(kind, module)(), "", "", rows)
            lines += [f"| *{name}* ({kind}) | | | |", *(_row(*row) for row in rows)] if rows else []
    heading = ["", "## `kwargs`", "", "Options of implementations, where the config names them.", ""]
    return [*heading, "| key | default | allowed | meaning |", "|---|---|---|---|", *lines]


def generate() -> dict[str, str]:
    """Contents of the generated files by path."""
    rows: list[tuple[str, str, str, str]] = []
    _lines(complete()(), "", "", rows)
    table = ["# Config reference", "", "Written from `stages/config` by `make config`.", ""]
    for key, default, allowed, description in rows:
        if "." not in key:
            table += ["", f"## `{key}`", "", description, ""] + (
                [*textwrap.wrap(f"Default: `{default}`", 120), ""] if default else []
            )
            table += ["| key | default | allowed | meaning |", "|---|---|---|---|"] if not default else []
        else:
            table.append(_row(key, default, allowed, description))
    table += _list_kwargs()
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **complete().model_json_schema()}
    return {
        "config/schema.json": json.dumps(schema, indent=1) + "\n",
        "docs/config.md": "\n".join(table).rstrip() + "\n",
    }


def write(root: Path) -> None:
    """Write the generated files below `root`."""
    for name, text in generate().items():
        (root / name).write_text(text, encoding="utf-8")
