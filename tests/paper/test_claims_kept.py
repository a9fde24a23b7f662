"""An audit that was interrupted goes on where it was: finished claims are kept and not tried again."""

import json

import pytest

from percuss.cli import main
from percuss.errors import Interrupted
from percuss.paper import claims
from percuss.paper.claim_common import Size
from percuss.paper.claims import report

SMALL = Size(starts=200, impacts=100)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    return claims.run(folder, seed=2, size=SMALL), folder


@pytest.mark.slow
def test_an_interrupted_audit_goes_on(tmp_path, whole):
    with pytest.raises(Interrupted, match="finished ones are kept") as stop:
        claims.run(tmp_path, seed=2, size=SMALL, progress=lambda p: p.part == "b")
    assert stop.value.archive == str(tmp_path / claims.PART)
    assert [path.name for path in tmp_path.iterdir()] == [claims.PART]
    kept = json.loads((tmp_path / claims.PART).read_text(encoding="utf-8"))
    assert list(kept["parts"]) == ["ends", "a"] and (kept["seed"], kept["starts"]) == (2, 200)

    with pytest.raises(Interrupted):
        claims.run(tmp_path, seed=2, size=SMALL, progress=lambda p: p.part == "e")
    seen = []
    claims.run(tmp_path, seed=2, size=SMALL, progress=lambda p: seen.append(p.part))
    assert set(seen) == {"e", "f", "beyond"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["REPORT.md", "claims.json"]
    for name in ("claims.json", "REPORT.md"):
        assert (tmp_path / name).read_bytes() == (whole[1] / name).read_bytes()


@pytest.mark.slow
def test_what_is_kept_is_what_was_found(whole):
    found, folder = whole
    raw = claims.audit(SMALL, 2)
    assert raw.to_json_dict() == found.to_json_dict()
    assert report(raw) == (folder / "REPORT.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "other", [{"seed": 3}, {"starts": 201}, {"impacts": 101}, {"percuss": "0"}, {"parts": 3}, None]
)
def test_claims_of_another_question_are_tried_again(tmp_path, other):
    path = tmp_path / claims.PART
    about = {"percuss": claims.__version__, "starts": 200, "impacts": 100, "seed": 2, "parts": {"ends": []}}
    path.write_text("no json" if other is None else json.dumps({**about, **other}), encoding="utf-8")
    seen = []

    def stop(progress):
        seen.append(progress.part)
        return True

    with pytest.raises(Interrupted):
        claims.run(tmp_path, seed=2, size=SMALL, progress=stop)
    assert seen == ["a"]


@pytest.mark.parametrize(
    "how", [Interrupted(3, 9, None, "an archive (-o, archive=) would keep it"), KeyboardInterrupt()]
)
def test_the_command_says_what_is_lost(tmp_path, monkeypatch, capsys, how):
    def run(*_, progress, **__):
        progress(claims.ClaimsProgress("c", 4, 11))
        raise how

    monkeypatch.setattr(claims, "run", run)
    assert main(["paper", "claims", "-o", str(tmp_path)]) == 130
    told = capsys.readouterr().err
    assert "after 4 of 11" in told and "in progress is lost" in told and "archive" not in told
