"""Questions with pictures to a language model: an OpenAI-compatible client behind a ledger on disk (docs/vlm.md)."""
