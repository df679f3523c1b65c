"""C++ headers of messages and services for roscpp, made of their types, as C++ plugins for ROS include them."""

from __future__ import annotations

from collections.abc import Iterator

from libgz.ros.types import NUMBERS, TIMES, Constant, Field, MessageType, ServiceType, message_type

__all__ = ["message_header", "service_headers"]

_NAMES = {"bool": "uint8_t", "byte": "int8_t", "char": "uint8_t", "float32": "float", "float64": "double"}
_STAMPS = {"time": "ros::Time", "duration": "ros::Duration"}
_REBOUND = "typename std::allocator_traits<A>::template rebind_alloc<{kind}>"
_TEXT = f"std::basic_string<char, std::char_traits<char>, {_REBOUND.format(kind='char')}>"

_MESSAGE = """\
// Messages {full}, made by libgz of their definition. License: Apache License 2.0.
#ifndef {guard}
#define {guard}
#include <memory>
#include <string>
#include <vector>
#include <boost/array.hpp>
#include <boost/shared_ptr.hpp>
#include <ros/types.h>
#include <ros/serialization.h>
#include <ros/builtin_message_traits.h>
#include <ros/message_operations.h>
{includes}
namespace {package} {{
template <class A>
struct {name}_
{{
  typedef {name}_<A> Type;
  {name}_() {{}}
  explicit {name}_(const A &) {{}}
{fields}
{constants}
  typedef boost::shared_ptr<{name}_<A>> Ptr;
  typedef boost::shared_ptr<const {name}_<A>> ConstPtr;
}};
{definitions}
typedef {name}_<std::allocator<void>> {name};
typedef boost::shared_ptr<{name}> {name}Ptr;
typedef boost::shared_ptr<const {name}> {name}ConstPtr;
template <class A>
std::ostream &operator<<(std::ostream &stream, const {name}_<A> &message)
{{
  ros::message_operations::Printer<{name}_<A>>::stream(stream, "", message);
  return stream;
}}
template <class A, class B>
bool operator==(const {name}_<A> &{one}, const {name}_<B> &{other})
{{
  return {equal};
}}
template <class A, class B>
bool operator!=(const {name}_<A> &one, const {name}_<B> &other)
{{
  return !(one == other);
}}
}}
namespace ros {{
namespace message_traits {{
{traits}
template <class A>
struct MD5Sum<{package}::{name}_<A>>
{{
  static const char *value() {{ return "{md5}"; }}
  static const char *value(const {package}::{name}_<A> &) {{ return value(); }}
  static const uint64_t static_value1 = 0x{first}ULL, static_value2 = 0x{second}ULL;
}};
template <class A>
struct DataType<{package}::{name}_<A>>
{{
  static const char *value() {{ return "{full}"; }}
  static const char *value(const {package}::{name}_<A> &) {{ return value(); }}
}};
template <class A>
struct Definition<{package}::{name}_<A>>
{{
  static const char *value() {{ return {text}; }}
  static const char *value(const {package}::{name}_<A> &) {{ return value(); }}
}};
}}
namespace serialization {{
template <class A>
struct Serializer<{package}::{name}_<A>>
{{
  template <typename Stream, typename T>
  inline static void allInOne(Stream &{stream}, T {message})
  {{
{parts}
  }}
  ROS_DECLARE_ALLINONE_SERIALIZER
}};
}}
namespace message_operations {{
template <class A>
struct Printer<{package}::{name}_<A>>
{{
  template <typename Stream>
  static void stream(Stream &{stream}, const std::string &{indent}, const {package}::{name}_<A> &{message})
  {{
{printed}
  }}
}};
}}
}}
#endif
"""
_TRAIT = """\
template <class A>
struct {trait}<{package}::{name}_<A>> : {value}Type
{{
}};
template <class A>
struct {trait}<const {package}::{name}_<A>> : {value}Type
{{
}};"""
_SERVICE = """\
// The service {full}, made by libgz of its definition. License: Apache License 2.0.
#ifndef {guard}
#define {guard}
#include <ros/service_traits.h>
#include <{package}/{name}Request.h>
#include <{package}/{name}Response.h>
namespace {package} {{
struct {name}
{{
  typedef {name}Request Request;
  typedef {name}Response Response;
  Request request;
  Response response;
  typedef Request RequestType;
  typedef Response ResponseType;
}};
}}
namespace ros {{
namespace service_traits {{
{traits}
}}
}}
#endif
"""
_SERVICE_TRAIT = """\
template <{template}>
struct {trait}<{package}::{kind}>
{{
  static const char *value() {{ return "{value}"; }}
  static const char *value(const {package}::{kind} &) {{ return value(); }}
}};"""


def message_header(kind: MessageType) -> str:
    """The header of a message."""
    package, _, name = kind.name.partition("/")
    names = [field.name for field in kind.fields]
    needed = {field.kind for field in kind.fields if not _is_simple(field)}
    traits = {
        "IsMessage": True,
        "IsFixedSize": _is_fixed(kind),
        "HasHeader": bool(kind.fields) and kind.fields[0][:2] == ("header", "std_msgs/Header"),
    }
    numbers = [constant for constant in kind.constants if _is_whole(constant)]
    others = [constant for constant in kind.constants if not _is_whole(constant)]
    return _MESSAGE.format(
        full=kind.name,
        guard=f"{package}_MESSAGE_{name}_H".upper(),
        package=package,
        name=name,
        includes="\n".join(f"#include <{other}.h>" for other in sorted(needed)),
        fields="\n".join(
            f"  typedef {_type(field)} _{field.name}_type;\n  _{field.name}_type {field.name}{_first(field)};"
            for field in kind.fields
        ),
        constants="\n".join(
            [
                *(f"  enum {{ {one.name} = {one.text}{'' if one.text.startswith('-') else 'u'} }};" for one in numbers),
                *(f"  static const {_constant_type(one)} {one.name};" for one in others),
            ]
        ),
        definitions="\n".join(
            f"template <class A>\nconst {_constant_type(one)} {name}_<A>::{one.name} = {_constant_text(one)};"
            for one in others
        ),
        equal=" && ".join(f"one.{field} == other.{field}" for field in names) or "true",
        traits="\n".join(
            _TRAIT.format(trait=trait, package=package, name=name, value=str(value)) for trait, value in traits.items()
        ),
        md5=kind.md5,
        first=kind.md5[:16],
        second=kind.md5[16:],
        text="\n".join(_quoted(line) for line in kind.text.splitlines()) or '""',
        parts="\n".join(f"    stream.next(message.{field});" for field in names),
        printed="\n".join(line for field in kind.fields for line in _printed(field)),
        **{word: word if names else "" for word in ("one", "other", "stream", "message", "indent")},  # if used
    )


def service_headers(kind: ServiceType) -> Iterator[tuple[str, str]]:
    """(name, text) of the headers of a service: its own, and those of its messages."""
    package, _, name = kind.name.partition("/")
    yield f"{name}Request", message_header(kind.request)
    yield f"{name}Response", message_header(kind.response)
    traits = [
        _SERVICE_TRAIT.format(template=template, trait=trait, package=package, kind=part, value=value)
        for trait, value in (("MD5Sum", kind.md5), ("DataType", kind.name))
        for part, template in ((name, ""), (f"{name}Request_<A>", "class A"), (f"{name}Response_<A>", "class A"))
    ]
    guard = f"{package}_MESSAGE_{name}_H".upper()
    yield name, _SERVICE.format(full=kind.name, guard=guard, package=package, name=name, traits="\n".join(traits))


def _is_simple(field: Field) -> bool:
    """Whether it has no message."""
    return field.kind in NUMBERS or field.kind in (*TIMES, "string")


def _is_fixed(kind: MessageType) -> bool:
    """Whether all messages of a type have the same size."""
    return all(
        field.size != 0 and field.kind != "string" and (_is_simple(field) or _is_fixed(message_type(field.kind)))
        for field in kind.fields
    )


def _element(kind: str) -> str:
    if kind == "string":
        return _TEXT
    if kind in NUMBERS or kind in TIMES:
        return _NAMES.get(kind) or _STAMPS.get(kind) or f"{kind}_t"
    return f"{kind.replace('/', '::')}_<A>"


def _type(field: Field) -> str:
    element = _element(field.kind)
    if field.size is None:
        return element
    if field.size:
        return f"boost::array<{element}, {field.size}>"
    return f"std::vector<{element}, {_REBOUND.format(kind=element)}>"


def _first(field: Field) -> str:
    """The initializer of a member: numbers are 0."""
    return "{}" if field.kind in NUMBERS and field.size != 0 else ""


def _is_whole(constant: Constant) -> bool:
    return constant.kind != "string" and not constant.kind.startswith("float")


def _constant_type(constant: Constant) -> str:
    return "std::string" if constant.kind == "string" else _element(constant.kind)


def _constant_text(constant: Constant) -> str:
    return _quoted(constant.text, "") if constant.kind == "string" else constant.text


def _quoted(line: str, end: str = "\\n") -> str:
    escaped = line.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}{end}"'


def _printed(field: Field) -> Iterator[str]:
    """The statements that print a field; roscpp's printers of plain values end their lines."""
    member, line = f"message.{field.name}", "" if _is_simple(field) else ' << "\\n"'
    printer = f'Printer<{_element(field.kind)}>::stream(stream, indent + "  ", '
    if field.size is None:
        yield f'    stream << indent << "{field.name}: "{line};'
        yield f"    {printer}{member});"
        return
    yield f'    stream << indent << "{field.name}[]\\n";'
    yield f"    for (std::size_t i = 0; i < {member}.size(); ++i)"
    yield "    {"
    yield f'      stream << indent << "  {field.name}[" << i << "]: "{line};'
    yield f"      {printer}{member}[i]);"
    yield "    }"
