"""What is kept of an answer: its head and its body, without what differs each time."""

import difflib
import hashlib
import io
import json
import re
import zipfile

MAX_BYTES = 30000
HEAD_LINES = 40
LINE_WIDTH = 110
HEADERS = ("Location", "Allow", "Retry-After", "Content-Disposition")
# Keys whose values are measured times.
TIMED = ("mean_ms",)


class Ids:
    """Ids that the server chooses at random, numbered in the order in which they appear."""

    PATTERN = re.compile(rb"\b(f|j|c|frame)-[0-9a-f]{12}(?![0-9a-f])")

    def __init__(self):
        self.numbered, self.actual, self.feed = {}, {}, None

    def hide(self, content):
        """Of the same length, so that files with lengths in them stay what they are."""
        if self.feed:
            content = content.replace(self.feed, b"0" * len(self.feed))
        content = self.PATTERN.sub(self._number, content)
        for actual, number in self.numbered.items():
            content = content.replace(self.code_of(actual), self.code_of(number))
        return content

    @staticmethod
    def code_of(name):
        """As CUP files have it."""
        return name.replace(b"-", b"").upper()

    def _number(self, match):
        found = match.group(0)
        if found not in self.numbered:
            number = b"%s-%012d" % (match.group(1), len(self.numbered) + 1)
            self.numbered[found], self.actual[number] = number, found
        return self.numbered[found]

    def show(self, text):
        """The request as the server understands it."""
        content = text.encode()
        if self.feed:
            content = content.replace(b"0" * len(self.feed), self.feed)
        return self.PATTERN.sub(lambda match: self.actual.get(match.group(0), match.group(0)), content).decode()


def pretty(value, indent="", width=LINE_WIDTH):
    """JSON with a line for each thing that fits into one."""
    line = json.dumps(value, ensure_ascii=False)
    if len(indent) + len(line) <= width or not isinstance(value, (dict, list)) or not value:
        return line
    inner = indent + " "
    if isinstance(value, dict):
        parts = [f"{json.dumps(key, ensure_ascii=False)}: {pretty(each, inner, width)}" for key, each in value.items()]
        return "{\n" + ",\n".join(inner + part for part in parts) + "\n" + indent + "}"
    return "[\n" + ",\n".join(inner + pretty(each, inner, width) for each in value) + "\n" + indent + "]"


def without_times(value):
    if isinstance(value, list):
        return [without_times(each) for each in value]
    if not isinstance(value, dict):
        return value
    return {key: "MEASURED" if key in TIMED else without_times(each) for key, each in value.items()}


def digest(content):
    return f"{len(content)} bytes, sha256 {hashlib.sha256(content).hexdigest()}"


def list_archive(content, ids):
    """Each file in it: those with ids are not equally long when compressed."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return "".join(f"{ids.hide(name.encode()).decode()}: {digest(ids.hide(archive.read(name)))}\n"
                       for name in archive.namelist())


def text_of(kind, body, ids, keep):
    """The whole body as text; None of a picture or another file of bytes."""
    if kind.endswith("json") and body:
        value = without_times(json.loads(ids.hide(body)))
        if keep:
            value = {key: value[key] for key in keep}
        return pretty(value) + "\n"
    if "zip" in kind or "kmz" in kind:
        return list_archive(body, ids)
    if kind.startswith("image/") or kind == "application/octet-stream":
        return None
    text = ids.hide(body).decode()
    return text if text.endswith("\n") else text + "\n"


def shortened(text):
    content = text.encode()
    if len(content) <= MAX_BYTES:
        return text
    lines = text.splitlines()[:HEAD_LINES]
    head = "\n".join(line[:300] for line in lines)
    return f"{digest(content)}; its first {HEAD_LINES} lines:\n{head}\n"


def head_of(request, status, headers, ids):
    kind = headers.get("Content-Type", "no content")
    lines = [request["ask"], f"{status} {kind}"]
    lines += [f"{name}: {headers[name]}" for name in HEADERS if headers.get(name)]
    return ids.hide("\n".join(lines).encode()).decode() + "\n\n"


def recorded_form(request, status, headers, body, ids):
    """What is written and compared, and the whole answer."""
    head = head_of(request, status, headers, ids)
    kind = headers.get("Content-Type", "").partition(";")[0].strip()
    text = text_of(kind, body, ids, request.get("keep"))
    if text is None:
        return head + digest(ids.hide(body)) + "\n", ids.hide(body)
    return head + shortened(text), (head + text).encode()


def difference(recorded, now, max_lines=16):
    lines = list(difflib.unified_diff(recorded.splitlines(), now.splitlines(), "recorded", "now", lineterm="", n=1))
    shown = [line[:160] for line in lines[2:2 + max_lines]]
    if len(lines) - 2 > max_lines:
        shown.append(f"… and {len(lines) - 2 - max_lines} lines more")
    return "\n".join("    " + line for line in shown)
