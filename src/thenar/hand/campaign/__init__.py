"""Campaigns: many episodes over processes, each done once and never lost."""

from thenar.hand.campaign.api import Campaign, Progress, run_campaign
from thenar.hand.campaign.row import Row, episode_seed
from thenar.hand.campaign.store import read_rows

__all__ = ["Campaign", "Progress", "Row", "episode_seed", "read_rows", "run_campaign"]
