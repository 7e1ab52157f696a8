MODULE WbEgmRight
    ! The right arm; loaded into T_ROB_R beside WbEgm.

    CONST string my_name:="right";

    ! Names of UDPUC devices: to the workbench's port, and its port for states.
    CONST string my_device:="WbRight";
    CONST string my_states:="WbRightStates";

    PROC main()
        wb_obey;
    ENDPROC

    PROC wb_join(INOUT egmident id,string device)
        EGMSetupUC ROB_R,id,"default",device\Joint\CommTimeout:=WB_SILENCE;
    ENDPROC
ENDMODULE
