"""Kernels without their helpers: a broken cache is none, and without the compiler they compute."""

import errno
import os
import pickle
import resource
import subprocess
import sys

import numpy as np
import pytest
from numba.core import caching

from kneecore import ParameterSpace, _jit, _kernel_folder, simulate


def double(x):
    return 2.0 * x


def triple(x):
    return 3.0 * x


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(_jit, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(_kernel_folder, "_told", set())
    return tmp_path


def files(folder, pattern):
    found = sorted(folder.rglob(pattern))
    assert found
    return found


def hits(kernel):
    return sum(kernel.stats.cache_hits.values())


def test_the_cache_is_in_use(folder, caplog):
    assert _jit.kernel(double)(2.0) == 4.0
    again = _jit.kernel(double)
    assert again(2.0) == 4.0
    assert hits(again) == 1
    assert not caplog.records


def check_recovery(folder, caplog, kernel=double, value=4.0):
    """Check that the kernel is right all the same, that one line says so, and that it is mended."""
    caplog.clear()
    broken = _jit.kernel(kernel)
    assert broken(2.0) == value
    assert hits(broken) == 0
    [record] = caplog.records
    assert record.name == "kneecore"
    assert str(folder) in record.message
    assert "\n" not in record.message
    mended = _jit.kernel(kernel)
    assert mended(2.0) == value
    assert hits(mended) == 1
    assert len(caplog.records) == 1


@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_file_that_was_cut_off(folder, caplog, pattern, share):
    _jit.kernel(double)(2.0)
    [file] = files(folder, pattern)
    os.truncate(file, int(share * file.stat().st_size))
    check_recovery(folder, caplog)


@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("content", [b"", b"\0" * 1000, b"I am no pickle", pickle.dumps(("a", 1))])
def test_a_file_with_other_content(folder, caplog, pattern, content):
    _jit.kernel(double)(2.0)
    [file] = files(folder, pattern)
    file.write_bytes(content)
    if pattern == "*.nbi" and content == pickle.dumps(("a", 1)):
        assert _jit.kernel(double)(2.0) == 4.0  # the index of another numba: not broken, but old
        return
    check_recovery(folder, caplog)


@pytest.mark.parametrize("seed", range(20))
def test_a_changed_byte_changes_no_number(folder, seed):
    _jit.kernel(double)(2.0)
    rng = np.random.default_rng(seed)
    for file in folder.rglob("*.nb?"):
        content = bytearray(file.read_bytes())
        content[rng.integers(len(content))] ^= 1 << rng.integers(8)
        file.write_bytes(content)
    assert _jit.kernel(double)(2.0) == 4.0
    assert _jit.kernel(double)(2.0) == 4.0


def test_other_code_under_the_kernels_name_is_not_run(folder, caplog):
    _jit.kernel(double)(2.0)
    _jit.kernel(triple)(2.0)
    [ours] = files(folder, "*double*.nbc")
    [other] = files(folder, "*triple*.nbc")
    ours.write_bytes(other.read_bytes())
    check_recovery(folder, caplog)


def test_code_for_another_signature_is_not_run(folder, caplog):
    kernel = _jit.kernel(double)
    kernel(2.0)
    kernel(np.array([2.0]))
    first, second = files(folder, "*double*.nbc")
    first.write_bytes(second.read_bytes())
    check_recovery(folder, caplog)


def test_a_full_disk(folder, caplog, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(caching.IndexDataCacheFile, "_save_data", full)
    kernel = _jit.kernel(double)
    assert kernel(2.0) == 4.0
    assert kernel(2) == 4.0
    assert _jit.kernel(triple)(2.0) == 6.0
    [record] = caplog.records
    assert "(No space left on device)" in record.message
    assert not list(folder.rglob("*.nb?"))  # an index without its code would be broken


def test_no_folder_for_the_cache(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    monkeypatch.setattr(_kernel_folder, "_told", set())
    _jit.cache_folder.cache_clear()
    try:
        assert _jit.kernel(double)(2.0) == 4.0
        assert _jit.kernel(triple)(2.0) == 6.0
    finally:
        _jit.cache_folder.cache_clear()
    assert len(caplog.records) == 1
    assert not list(tmp_path.rglob("*.nb?"))


def simulated(*, before=None, **environment):
    return subprocess.run(
        [sys.executable, "-m", "kneecore.simulate", "--json"],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=before,
    )


def limit_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (16_384, 16_384))


def test_the_command_with_broken_caches_prints_the_same_bytes(tmp_path):
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    whole = simulated(**cache)
    assert whole.returncode == 0
    assert whole.stderr == ""
    for file in files(tmp_path, "*.nb?"):
        os.truncate(file, file.stat().st_size // 2)
    broken = simulated(**cache)
    limited = simulated(NUMBA_CACHE_DIR=str(tmp_path / "other"), before=limit_files)
    for done in (broken, limited):
        assert done.returncode == 0
        assert done.stdout == whole.stdout
        assert done.stderr.count("\n") == 1
        assert done.stderr.startswith("the kernels' cache in ")
    assert simulated(**cache).stderr == ""


WITHOUT_COMPILER = """
import numpy as np
from kneecore import ParameterSpace, simulate
x = ParameterSpace().baseline
for solver in ("dynamics", "equilibrium"):
    print(*simulate(x, solver=solver).flexion)
print(simulate(x, solver="equilibrium").lost_at)
"""


def test_without_the_compiler_the_numbers_are_the_same():
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", WITHOUT_COMPILER],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    x = ParameterSpace().baseline
    lines = done.stdout.splitlines()
    for line, solver in zip(lines, ("dynamics", "equilibrium"), strict=False):
        expected = simulate(x, solver=solver).flexion
        np.testing.assert_allclose(np.array(line.split(), float), expected, atol=1e-9)
    assert lines[2] == "nan"
