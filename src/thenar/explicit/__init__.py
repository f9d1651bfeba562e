"""Operations on automata as free functions over explicit states."""
