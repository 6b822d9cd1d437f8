"""What people would use instead, each set up to win as its documentation allows; one file a tool."""
