"""The address of a service."""

from __future__ import annotations

from urllib.parse import urlsplit

from revprio.errors import AddressError


def service_url(url: str) -> str:
    """Returns the address without a slash at its end; adds `http://` if there is no scheme.

    Raises an `AddressError` if it is not an address of HTTP.
    """
    full = url if "://" in url else f"http://{url}"
    try:
        parts = urlsplit(full)
        is_address = parts.scheme in {"http", "https"} and bool(parts.hostname) and parts.port != 0
    except ValueError:
        is_address = False
    if not is_address:
        raise AddressError(url)
    return full.rstrip("/")
