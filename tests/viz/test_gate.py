"""Who is let in: the rules, without a server."""

import pytest
from websockets.datastructures import Headers

from kneecore import ParameterError
from kneeviz.server import gate as gates
from kneeviz.server.gate import Gate

TOKEN = "a-token-of-my-own"
HOME = Gate.of("127.0.0.1", token=None)
OPEN = Gate.of("0.0.0.0", token=False)
GUARDED = Gate.of("0.0.0.0", token=TOKEN)


def asked(host="127.0.0.1:8080", origin=None, cookie=None):
    headers = Headers(Host=host)
    if origin is not None:
        headers["Origin"] = origin
    if cookie is not None:
        headers["Cookie"] = cookie
    return headers


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1:8080", "localhost:8080", "LOCALHOST", "localhost.:9", "[::1]:8080", "127.0.0.2:1"],
)
def test_names_of_this_machine_are_let_in(host):
    assert HOME.refusal("/", asked(host)) is None


@pytest.mark.parametrize(
    "host",
    [
        "evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example",
        "192.168.1.5:8080", "", "localhost:x", "localhost:8080@evil.example",
        "evil.example#localhost",
        "localhost, evil.example",
    ],
)  # fmt: skip
def test_other_names_are_not(host):
    assert HOME.refusal("/", asked(host)) is not None


def test_a_request_names_one_host():
    twice = asked("localhost")
    twice["Host"] = "localhost"
    assert HOME.refusal("/", Headers()) is not None
    assert HOME.refusal("/", twice) is not None


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1:8080", "http://127.0.0.1:8080"),
        ("localhost:9000", "http://localhost:9000"),
        ("localhost", "http://localhost"),
        ("localhost", "https://localhost:443"),
        ("[::1]:8080", "http://[::1]:8080"),
        ("127.0.0.1:8080", None),
    ],
)
def test_our_own_page_may_speak(host, origin):
    assert HOME.refusal("/", asked(host, origin)) is None


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example", "http://127.0.0.1:9999", "http://localhost:8080", "null", "",
        "file://", "http://127.0.0.1:8080.evil.example", "http://127.0.0.1:8080@evil.example",
        "chrome-extension://127.0.0.1:8080", "http://evil.example/127.0.0.1:8080", "127.0.0.1:8080",
    ],
)  # fmt: skip
def test_pages_of_other_sites_may_not(origin):
    assert "other sites" in HOME.refusal("/", asked(origin=origin))


def test_one_good_origin_does_not_cover_a_bad_one():
    headers = asked(origin="http://127.0.0.1:8080")
    headers["Origin"] = "http://evil.example"
    assert HOME.refusal("/", headers) is not None


def test_an_allowed_name_is_a_name_and_an_origin():
    proxied = Gate.of("127.0.0.1", token=False, allowed=["Knee.Example.org"])
    page = "https://knee.example.org"
    assert proxied.refusal("/", asked("knee.example.org", page)) is None
    assert proxied.refusal("/", asked("127.0.0.1:8080", page)) is None, "a proxy with its own Host"
    assert proxied.refusal("/", asked("example.org", "https://example.org")) is not None


@pytest.mark.parametrize("name", ["http://x.org", "x.org:80", "a b", "*", "x.org/", ".", ""])
def test_allow_host_takes_names_only(name):
    with pytest.raises(ParameterError, match="allow_host"):
        Gate.of("127.0.0.1", token=None, allowed=[name])


def test_on_all_addresses_any_address_is_a_name_but_no_strange_name_is():
    assert OPEN.refusal("/", asked("192.168.1.5:8080", "http://192.168.1.5:8080")) is None
    assert OPEN.refusal("/", asked("evil.example:8080", "http://evil.example:8080")) is not None


class TestToken:
    @pytest.mark.parametrize(
        ("host", "allowed", "needed"),
        [
            ("127.0.0.1", (), False), ("localhost", (), False), ("::1", (), False),
            ("0.0.0.0", (), True), ("::", (), True), ("", (), True), ("192.0.2.1", (), True),
            ("127.0.0.1", ("knee.example.org",), True), ("127.0.0.1", ("localhost",), False),
        ],
    )  # fmt: skip
    def test_it_is_needed_where_others_can_reach_the_server(self, host, allowed, needed):
        assert (Gate.of(host, token=None, allowed=allowed).token is not None) is needed
        assert Gate.of(host, token=False, allowed=allowed).token is None
        assert Gate.of(host, token=True, allowed=allowed).token is not None

    def test_it_is_new_every_time_and_long(self):
        tokens = {gates.new_token() for _ in range(100)}
        assert len(tokens) == 100
        assert min(map(len, tokens)) >= 22  # 128 bits

    def test_without_it_nobody_is_let_in(self):
        for target in (
            "/",
            "/?token=",
            "/?token=a-token-of-my-owm",
            f"/?tokens={TOKEN}",
            f"/{TOKEN}",
        ):
            assert "token" in GUARDED.refusal(target, asked())
        assert TOKEN not in GUARDED.refusal("/", asked())

    def test_with_it_the_page_gets_a_cookie_that_lets_it_come_back(self):
        answer = GUARDED.answer_headers(f"/?token={TOKEN}&fixedDpr=1", asked())
        cookie, *attributes = answer["Set-Cookie"].split("; ")
        assert {"HttpOnly", "SameSite=Strict"} <= set(attributes)
        assert GUARDED.refusal("/", asked(cookie=f"other=1; {cookie}")) is None
        assert GUARDED.refusal("/", asked("127.0.0.1:8081", cookie=cookie)) is not None
        assert "Set-Cookie" not in HOME.answer_headers("/", asked())

    @pytest.mark.parametrize(
        "cookie",
        ["kneeviz-8080=", "kneeviz-8080=x", f"x={TOKEN}", "=;;=", "a" * 9000],
    )
    def test_other_cookies_let_nobody_in(self, cookie):
        assert GUARDED.refusal("/", asked(cookie=cookie)) is not None

    @pytest.mark.parametrize(
        "token", ["", "short", "with space in the middle", "x" * 200, "a/b?c=d&e=f-12345"]
    )
    def test_one_that_can_be_guessed_or_breaks_the_address_is_refused(self, token):
        with pytest.raises(ParameterError, match="token"):
            Gate.of("127.0.0.1", token=token)

    def test_a_foreign_page_is_refused_even_with_it(self):
        assert GUARDED.refusal(f"/?token={TOKEN}", asked(origin="http://evil.example")) is not None


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.0.0.1", "http://127.0.0.1:8080"), ("::1", "http://[::1]:8080"),
        ("0.0.0.0", "http://127.0.0.1:8080"), ("::", "http://[::1]:8080"),
        ("localhost", "http://localhost:8080"), ("fe80::1%eth0", "http://[fe80::1%25eth0]:8080"),
    ],
)  # fmt: skip
def test_the_address_can_be_opened(host, address):
    assert Gate.of(host, token=False).url(8080) == address
    assert Gate.of(host, token=TOKEN).url(8080) == f"{address}/?token={TOKEN}"


def test_the_warning_names_the_risk_where_there_is_one():
    assert HOME.warning(8080) is None
    assert "whoever can reach 0.0.0.0:8080" in OPEN.warning(8080)
    assert "has the token" in GUARDED.warning(8080)
    assert "not encrypted" in Gate.of("::", token=None).warning(80)


def test_our_page_is_not_shown_inside_another_site_s():
    answer = HOME.answer_headers("/", asked())
    assert "frame-ancestors 'self'" in answer["Content-Security-Policy"]
    assert answer["Referrer-Policy"] == "no-referrer"
