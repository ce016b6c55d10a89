from breastrig.core.lru_cache import LruCache


def test_what_was_not_used_for_longest_goes_first() -> None:
    kept: LruCache[str, int] = LruCache(2)
    kept.put("a", 1)
    kept.put("b", 2)
    assert kept.get("a") == 1
    kept.put("c", 3)
    assert (kept.get("a"), kept.get("b"), kept.get("c"), len(kept)) == (1, None, 3, 2)
    kept.put("a", 4)
    assert (kept.get("a"), len(kept)) == (4, 2)
