"""Files written to deceive: families of them, with exact twins beside."""
